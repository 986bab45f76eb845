#!/bin/sh
# Builds the cutting and lattice libraries and a program that hashes a fixed history, with g++ and clang++ at
# -O0, -O2 and -O3, and compares what they print with the hash in history.h. Needs some minutes.
#   [COMPILERS="g++ clang++"] [LEVELS="-O0 -O2 -O3"] tests/sim/cutting/compilers/compilers.sh [OUT]
set -u
root=$(cd "$(dirname "$0")/../../../.." && pwd)
out=${1:-$root/build/compilers}
failed=0
cache=$(command -v ccache || true)
for compiler in ${COMPILERS:-g++ clang++}; do
  command -v "$compiler" > /dev/null || { echo "$compiler: not installed" >&2; failed=1; continue; }
  for level in ${LEVELS:--O0 -O2 -O3}; do
    dir=$out/$compiler$level
    mkdir -p "$dir"
    objects=
    # What blades are built from strokes with, elements and the fuzz of readers are not needed.
    for source in "$root"/sim/geometry/bvh.cpp "$root"/sim/geometry/exact/*.cpp "$root"/sim/cutting/*/*.cpp "$root"/sim/lattice/*.cpp \
        "$root"/tests/bench/fuzz/*.cpp "$root"/tests/sim/cutting/compilers/main.cpp; do
      case ${source##*/} in
        blade_*|drawn_*|pull_back*|snap_*|world_*|stroke*|wall_map*|wound*|attach*|sheet_*|stencil*|fem_*|embedding*|grid_fit*|readers*) continue ;;
      esac
      object=$dir/$(echo "${source#"$root"/}" | tr '/' '_').o
      $cache "$compiler" -std=c++20 $level -ffp-contract=off -I"$root" -isystem /usr/include/eigen3 -c "$source" -o "$object" || exit 1
      objects="$objects $object"
    done
    rm -f "$dir/all.a" && ar rcs "$dir/all.a" $objects && "$compiler" $level "$object" "$dir/all.a" -lfmt -o "$dir/history" || exit 1
    printf '%-8s %s  ' "$compiler" "$level"
    "$dir/history" || failed=1
  done
done
exit $failed
