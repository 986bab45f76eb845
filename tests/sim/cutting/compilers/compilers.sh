#!/bin/sh
# Builds the cutting, lattice and geometry libraries and a program that hashes a fixed history, with g++ and clang++ at
# -O0, -O2 and -O3, and compares what they print with the hash in history.h. Needs some minutes.
#   tests/sim/cutting/compilers/compilers.sh [OUT]
set -u
root=$(cd "$(dirname "$0")/../../../.." && pwd)
out=${1:-$root/build/compilers}
failed=0
for compiler in g++ clang++; do
  command -v "$compiler" > /dev/null || { echo "$compiler: not installed" >&2; failed=1; continue; }
  for level in -O0 -O2 -O3; do
    dir=$out/$compiler$level
    mkdir -p "$dir"
    objects=
    for source in "$root"/sim/geometry/*.cpp "$root"/sim/geometry/exact/*.cpp "$root"/sim/cutting/*.cpp "$root"/sim/lattice/*.cpp \
        "$root"/sim/*.cpp "$root"/app/bench/fuzz/*.cpp "$root"/tests/sim/cutting/compilers/main.cpp; do
      [ -e "$source" ] || continue
      case $source in */stencil*|*/fem_assembly.cpp|*/obj.cpp|*/world*.cpp) continue ;; esac
      object=$dir/$(echo "${source#"$root"/}" | tr '/' '_').o
      if [ ! -e "$object" ] || [ "$source" -nt "$object" ]; then
        "$compiler" -std=c++20 $level -ffp-contract=off -I"$root" -isystem /usr/include/eigen3 -c "$source" -o "$object" || exit 1
      fi
      objects="$objects $object"
    done
    "$compiler" $level $objects -o "$dir/history" -pthread || exit 1
    printf '%-8s %s  ' "$compiler" "$level"
    "$dir/history" || failed=1
  done
done
exit $failed
