#!/usr/bin/env bash
# The library as others use it: installed into a folder of its own and found there by the examples, which are built out of the
# tree and run; and as a part of another build (add_subdirectory).
#
#   tests/library/outside.sh SOURCE BUILD PROGRAM
#
# As a part of another build everything is configured and generated, and of it what the smallest example needs is compiled:
# all of it again would take as long as the build of the program.
set -euo pipefail
source=$1 build=$2 program=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "outside: $*" >&2; exit 1; }
quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }; }

for part in dev data; do quietly cmake --install "$build" --prefix "$work/prefix" --component $part; done
grep -rl "$source" "$work/prefix"/lib*/cmake "$work/prefix"/lib*/*/cmake 2>/dev/null && fail "a configuration names the source's own folder"

# Every header that is installed has those that it includes.
headers=$work/prefix/include/limberg
(cd "$headers" && grep -rhoE '^#include "[^"]+"' . | sort -u | cut -d'"' -f2) | while read -r header; do
  [ -f "$headers/$header" ] || { echo "outside: $header is included and not installed" >&2; exit 1; }
done

# From a copy of the examples, so that nothing beside them can be found.
cp -r "$source/library/examples" "$work/examples"
quietly cmake -S "$work/examples" -B "$work/found" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_BUILD_TYPE=Release
quietly cmake --build "$work/found"
cd "$work"
export LIMBERG_DATA="$work/prefix/share/limberg"
script=$LIMBERG_DATA/recordings/rhomboid.jsonl
found/operate rhomboid "$script" 7 >operated || fail "the example operate ends with $?"
"$program" operate rhomboid "$script" --cell-mm 7 >program || [ $? = 3 ] || fail "limberg operate"
hash=$(awk '/^state_hash/{print $2}' operated)
grep -q "state_hash $hash" program || fail "the example's hash is $hash; the program says $(cat program)"
found/hand_path "$LIMBERG_DATA/recordings/rhomboid.lcm" | grep -Eq '^[0-9]+ readings, [0-9.]+ mm$' || fail "hand_path"
found/script_lines "$script" | tail -1 | grep -q "actions on rhomboid" || fail "script_lines"
# Input that is wrong is told in the program's words.
found/operate nowhere "$script" 2>wrong && fail "a scene that is not there was taken"
grep -q "operate: nowhere: no such scene; expected" wrong || fail "$(cat wrong)"
# Of scripts alone the linker takes nothing of the solver.
! nm -C found/script_lines | grep -q "limberg::World" || fail "script_lines has a patient in it"

# Another version is refused.
mkdir newer && printf 'cmake_minimum_required(VERSION 3.25)\nproject(newer CXX C)\nfind_package(Limberg 9.0 REQUIRED)\n' >newer/CMakeLists.txt
cmake -S newer -B newer/build -DCMAKE_PREFIX_PATH="$work/prefix" >log 2>&1 && fail "version 9.0 was found"
grep -q "LimbergConfig.cmake, version" log || fail "$(cat log)"

# As a part of another build: the library alone, no tests, no program, and the names that find_package gives.
quietly cmake -S "$work/examples" -B "$work/part" -G Ninja -DLIMBERG_SOURCE="$source" -DCMAKE_BUILD_TYPE=Release
ninja -C part -t targets all >targets
grep -q "test_geometry\|limberg_commands" targets && fail "the program or its tests are a part of another's build"
quietly cmake --build part --target script_lines
part/script_lines "$script" | tail -1 | grep -q "actions on rhomboid" || fail "script_lines of add_subdirectory"
quietly cmake --install part --prefix "$work/none"
[ ! -e "$work/none/lib" ] || fail "another's installation brings Limberg's files"
echo "outside: find_package and add_subdirectory, hash $hash"
