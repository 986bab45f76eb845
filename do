#!/usr/bin/env bash
# The two commands of Limberg, and twelve for those who work on it.
#   ./do demo [NAME]   build, then replay a shipped recording headless into out/demo (default: rhomboid)
#   ./do test          check the format, build (Python's module too), run every test, and name what was skipped
#   ./do build         build only; the binary is build/limberg
#   ./do sanitize      every test under AddressSanitizer + UBSan, then under ThreadSanitizer (hours; 'address' or 'thread': one)
#   ./do fuzz [SECONDS] [ENTRY ...]  readers and packets under libFuzzer, each so long (600 s), from tests/fuzz/corpus and back into it
#   ./do record [NAME] build, then make the recorded stream of a shipped script anew
#   ./do bench [SUITE] run a benchmark suite (default: speed); for cutting CGAL is installed too, to compare with
#   ./do figures [RESULT.json ...] keep results of limberg bench in docs/figures, write docs/figures.md
#   ./do face          make the surface and the picture of the shipped face anew
#   ./do headset       install what a headset needs (OpenXR), build with it, and test it against a runtime of our own
#   ./do python        build Python's module into build-python/python, and test it
#   ./do cluster       install Slurm, and test studies on a cluster of two nodes on this machine
#   ./do words         list the texts anew for translations, and merge them into the tables of app/words
#   ./do format        clang-format over the tree
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential cmake ninja-build ccache
  libeigen3-dev libsuitesparse-dev libmetis-dev libopenblas-dev liblcm-dev liblcm-bin
  libosmesa6-dev libgl-dev libglfw3-dev libimgui-dev pkg-config libfreetype-dev fonts-dejavu-core libpng-dev libjpeg-dev zlib1g-dev
  libtomlplusplus-dev nlohmann-json3-dev libcli11-dev libfmt-dev libgtest-dev libboost-dev libbullet-dev libgdcm-dev
  libjs-three  # put into report.html, to turn operations
  xvfb)  # the tests of the window open it where there is no screen

ensure_packages() {
  local missing=() p
  for p in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'install ok installed' || missing+=("$p")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  local root=()
  if [ "$(id -u)" != 0 ]; then root=(sudo); fi
  echo "installing: ${missing[*]}"
  if { command -v apt-get >/dev/null && { [ ${#root[@]} -eq 0 ] || command -v sudo >/dev/null; }; } &&
     "${root[@]}" apt-get update -qq &&
     "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null; then
    return 0
  fi
  echo "limberg: could not install packages; install these and run again:" >&2
  echo "  apt-get install ${missing[*]}" >&2
  exit 2
}

# How many steps of the build are done, of how many, after how many seconds.
export NINJA_STATUS='[%f/%t, %e s] '

# build [TARGET]: everything, or one target. Jobs: one per core, but not more than one per 1.5 GB of memory.
build() {
  ensure_packages
  [ -f build/build.ninja ] || { echo "configuring"; cmake --preset release >/dev/null; }
  cmake --build build --parallel "$(jobs)" ${1:+--target "$1"}
}

jobs() {
  local jobs memory_mb
  jobs=$(nproc)
  memory_mb=$(awk '/MemAvailable/ {print int($2 / 1024)}' /proc/meminfo)
  [ "$jobs" -le $((memory_mb / 1500 + 1)) ] || jobs=$((memory_mb / 1500 + 1))
  echo "$jobs"
}

# Every file as clang-format would write it (.clang-format: 120 columns).
check_format() {
  packages+=(clang-format)
  ensure_packages
  local wrong
  # Its exit status says no more than the lines, and must not end this script before they are shown.
  wrong=$(git ls-files '*.h' '*.cpp' | { xargs clang-format --dry-run -Werror 2>&1 || true; } | sed -n 's/^\([^:]*\):.*clang-format-violations.*/\1/p' | sort -u)
  [ -z "$wrong" ] || { printf 'limberg: not formatted; expected what ./do format makes of:\n%s\n' "$wrong" >&2; return 1; }
}

# run_tests FOLDER [TIMEOUT_S]: all tests; the last lines name the skipped ones with their reasons, and count.
run_tests() {
  local status=0 log="$1/Testing/Temporary/LastTest.log" skipped failed
  ctest --test-dir "$1" --output-on-failure --parallel "$(nproc)" --timeout "${2:-600}" || status=$?
  skipped=$(awk '/^[0-9]+\/[0-9]+ Testing: /{name = $3} /: Skipped$/{getline why; print "  " name ": " why}' "$log" | sort -u)
  if [ -n "$skipped" ]; then
    printf 'skipped:\n%s\n' "$skipped"
  fi
  failed=$(grep -c . "$1/Testing/Temporary/LastTestsFailed.log" 2>/dev/null || true)
  [ $status != 0 ] || failed=0
  awk -v failed="${failed:-0}" -v skipped="$(printf '%s' "$skipped" | grep -c . || true)" \
    '/^[0-9]+\/[0-9]+ Testing: /{n++} END {printf "%d passed, %d failed, %d skipped\n", n - failed - skipped, failed, skipped}' "$log"
  return $status
}

# The recording is replayed; the same operation by script at three cell sizes gives the small table in the report (a head has
# no cells). That table is kept until program, scene or script change.
# The scene of a shipped script, which its first line names.
scene_of() { sed -n '1s/.*"scene":"\([^"]*\)".*/\1/p' "recordings/$1.jsonl"; }

demo() {
  local name=$1 out=out/demo
  local table=$out/convergence.json
  [ -f "recordings/$name.lcm" ] || { echo "limberg: recordings/$name.lcm: no such recording; expected one of: $(cd recordings && ls -- *.lcm | tr '\n' ' ')" >&2; exit 2; }
  mkdir -p "$out"
  if [ -f "recordings/$name.jsonl" ] && ! grep -q "^\[head\]" "app/scenes/$(scene_of "$name").toml"; then
    local stamp="$name $(cat build/limberg "app/scenes/$name.toml" "recordings/$name.jsonl" | cksum)"
    if [ ! -f "$table" ] || [ "$(cat "$out/.convergence" 2>/dev/null)" != "$stamp" ]; then
      # Status 3: one of them has something bad in its verdict, and says so; the table stands.
      build/limberg operate "$name" "recordings/$name.jsonl" --cells 5,3.5,2.5 --json "$table" || [ $? = 3 ]
      echo "$stamp" >"$out/.convergence"
    fi
    set -- --convergence "$table"
  else
    set --
  fi
  build/limberg replay "recordings/$name.lcm" --lockstep --out "$out" --json "$out/result.json" "$@"
}

# Python's module, in a folder of its own: its archives are position independent, those of build/ stay as they are.
python_module() {
  [ -f build-python/build.ninja ] || cmake -S . -B build-python -G Ninja -DLIMBERG_PYTHON=ON -DLIMBERG_APP=OFF -DLIMBERG_TESTS=OFF >/dev/null
  cmake --build build-python --parallel "$(jobs)" --target limberg_python
}
python_packages=(python3-dev pybind11-dev python3-pybind11 python3-numpy)

case "${1:-help}" in
  build) build ;;
  test)
    check_format
    build
    # Without its packages the tests of Python's module are skipped, and say so.
    if (packages+=("${python_packages[@]}") && ensure_packages); then python_module; fi
    run_tests build
    ;;
  sanitize)
    ensure_packages
    for kind in ${2:-address thread}; do
      case $kind in address) preset=asan ;; thread) preset=tsan ;; *) echo "limberg: sanitize $kind: expected address or thread" >&2; exit 2 ;; esac
      [ -f "build-$preset/build.ninja" ] || cmake --preset $preset >/dev/null
      cmake --build "build-$preset" --parallel "$(jobs)"
      export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp"
      run_tests "build-$preset" 7200
    done
    ;;
  fuzz)  # readers anew with clang, the rest as build/ has it
    packages+=(clang-16 libclang-rt-16-dev)
    ensure_packages
    build limberg
    [ -f build-fuzz/build.ninja ] || cmake -S tests/fuzz -B build-fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++-16 >/dev/null
    cmake --build build-fuzz --parallel "$(jobs)"
    tests/fuzz/run.sh "${@:2}"
    ;;
  demo)
    build limberg
    demo "${2:-rhomboid}"
    ;;
  record)
    build limberg
    for name in ${2:-rhomboid zplasty craniofacial le_fort_1 sagittal_split genioplasty autorotation}; do
      case "$name" in zplasty) seed=3 ;; *) seed=7 ;; esac  # as recordings/README.md says
      build/limberg emulate "$(scene_of "$name")" "recordings/$name.jsonl" --out "recordings/$name.lcm" --seed "$seed" --replace
    done
    ;;
  bench)
    if [ "${2:-}" = cutting ]; then  # CGAL (GPL) for a program of its own; nothing else links it
      packages+=(libcgal-dev)
      ensure_packages
      cmake --preset release >/dev/null
      build limberg_bench_cgal
    fi
    if [ "${2:-}" = verification ]; then  # an independent solver to compare with, a program of its own
      packages+=(calculix-ccx)
      ensure_packages
    fi
    build limberg
    build limberg_bench_program
    build/limberg bench "${2:-speed}" "${@:3}"
    ;;
  figures)
    build limberg_figures
    build/limberg_figures docs/figures docs/figures.md "${@:2}"
    ;;
  words)  # the tables keep what they have; new texts are empty, or guessed and marked fuzzy
    packages+=(gettext)
    build test_words
    LIMBERG_WRITE_TEXTS=1 build/tests/test_words --gtest_filter=Texts.TheListIsThatOfCodeAndData
    for table in app/words/*.po; do msgmerge --update --backup=none --no-wrap --quiet "$table" app/words/limberg.pot; done
    ;;
  face)  # what app/scenes/face.toml operates on
    build limberg_face_surface
    build/limberg_face_surface app/scenes
    ;;
  headset)  # build/ has it from then on; -DLIMBERG_OPENXR=OFF takes it out again
    packages+=(libopenxr-dev libopenxr-loader1 openxr-layer-corevalidation libegl-dev libx11-dev)
    ensure_packages
    cmake --preset release -DLIMBERG_OPENXR=ON >/dev/null
    build limberg
    build test_headset
    ctest --test-dir build --output-on-failure -R '^(Room|Headset)'
    ;;
  python)
    packages+=("${python_packages[@]}")
    build limberg
    python_module
    tests/python/run.sh build-python/python build/limberg
    ;;
  cluster)  # nothing else needs these packages; limberg only calls sbatch, squeue and scontrol where they are
    packages+=(slurmctld slurmd slurm-client munge iproute2 util-linux procps)
    ensure_packages
    build limberg
    bash tests/slurm/study_on_cluster.sh build/limberg
    ;;
  format)
    git ls-files '*.h' '*.cpp' | xargs clang-format -i
    ;;
  *) sed -n '2,15s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
