#!/usr/bin/env bash
# The two commands of Limberg, and three for those who work on it.
#   ./do demo [NAME]   build, then replay a shipped recording headless into out/demo (default: rhomboid)
#   ./do test          build, then run every test
#   ./do build         build only; the binary is build/limberg
#   ./do bench [SUITE] run a benchmark suite (default: speed)
#   ./do format        clang-format over the tree
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential cmake ninja-build ccache
  libeigen3-dev libsuitesparse-dev libmetis-dev libopenblas-dev liblcm-dev liblcm-bin
  libosmesa6-dev libgl-dev libfreetype-dev fonts-dejavu-core libpng-dev
  libtomlplusplus-dev nlohmann-json3-dev libcli11-dev libfmt-dev libgtest-dev libboost-dev)

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

build() {
  ensure_packages
  [ -f build/build.ninja ] || cmake --preset release >/dev/null
  cmake --build build --parallel "$(nproc)"
}

case "${1:-help}" in
  build) build ;;
  test)
    build
    ctest --test-dir build --output-on-failure --parallel "$(nproc)" --timeout 600
    ;;
  demo)
    build
    name=${2:-rhomboid}
    build/limberg replay "recordings/$name.lcm" --lockstep --out out/demo --json out/demo/result.json
    echo "report: out/demo/report.html"
    ;;
  bench)
    build
    build/limberg bench "${2:-speed}" "${@:3}"
    ;;
  format)
    git ls-files '*.h' '*.cpp' | xargs clang-format -i
    ;;
  *) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
