#!/usr/bin/env bash
# Builds the program for another processor (aarch64), replays shipped recordings under qemu-user, and compares with what was
# recorded here: the same bits. On Debian, as root, with the network: it installs g++-aarch64-linux-gnu and qemu-user, and
# unpacks the libraries of that processor into OUT/root, beside the system's; Bullet it builds from Debian's source, since
# Debian's own for this processor fuses multiplications with additions and ends with other bits. Half an hour on two cores.
#   tests/aarch64/replay.sh [OUT] [RECORDING ...]     (default: build-aarch64; rhomboid craniofacial)
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "${1:-build-aarch64}")
recordings=("${@:2}")
[ ${#recordings[@]} -gt 0 ] || recordings=(rhomboid craniofacial)
root=$out/root
lib=$root/usr/lib/aarch64-linux-gnu

if [ ! -e "$root/unpacked" ]; then
  dpkg --add-architecture arm64
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends g++-aarch64-linux-gnu qemu-user > /dev/null
  mkdir -p "$out/packages" "$root"
  wanted=(libsuitesparse-dev libmetis-dev libbullet-dev liblcm-dev libfmt-dev zlib1g-dev libosmesa6-dev libfreetype-dev libpng-dev libjpeg62-turbo-dev)
  all=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces --no-enhances \
    "${wanted[@]/%/:arm64}" | grep '^[a-z].*:arm64$' | sort -u)
  # Of these some are virtual and have no file; and the compiler has its own C library.
  real=$(apt-cache show --no-all-versions $all 2> /dev/null |
    awk '/^Package:/ {name = $2} /^Architecture:/ {print name ":" $2}' | sort -u |
    grep -Ev '^(libc6-dev|linux-libc-dev|libgcc-.*-dev|libstdc\+\+-.*-dev):')
  (cd "$out/packages" && apt-get download -qq $real)
  for file in "$out"/packages/*.deb; do dpkg -x "$file" "$root"; done
  touch "$root/unpacked"
fi

export LIMBERG_AARCH64_ROOT=$root
bullet=$out/bullet
if [ ! -e "$bullet/built" ]; then
  mkdir -p "$bullet/source" "$bullet/lib"
  source_list=/etc/apt/sources.list.d/limberg-bullet-source.sources
  sed 's/^Types: deb$/Types: deb-src/' /etc/apt/sources.list.d/debian.sources > $source_list
  (cd "$bullet" && apt-get update -qq && apt-get source -qq --download-only bullet)
  rm $source_list
  tar xf "$bullet"/bullet_*.orig.tar.* -C "$bullet/source" --strip-components=1
  cmake -S "$bullet/source" -B "$bullet/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/tests/aarch64/toolchain.cmake" \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS="-ffp-contract=off -w" -DBUILD_SHARED_LIBS=ON -DBUILD_EXTRAS=OFF \
    -DBUILD_BULLET2_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_CPU_DEMOS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_PYBULLET=OFF \
    > /dev/null
  cmake --build "$bullet/build" --parallel "$(nproc)" --target BulletDynamics
  find "$bullet/build/src" -name 'lib*.so*' -exec cp -P {} "$bullet/lib/" \;
  touch "$bullet/built"
fi
cmake -S . -B "$out/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/tests/aarch64/toolchain.cmake" -DLIMBERG_TESTS=OFF \
  -DLIMBERG_WINDOW=OFF -DLIMBERG_EGL=OFF -Dfmt_DIR="$lib/cmake/fmt" > /dev/null
cmake --build "$out/build" --parallel "$(nproc)" --target limberg

failed=0
for name in "${recordings[@]}"; do
  echo "$name"
  LD_LIBRARY_PATH= qemu-aarch64 -L "$root" -E LD_LIBRARY_PATH="$bullet/lib:$lib:$lib/openblas-pthread:$lib/blas:$lib/lapack" \
    "$out/build/limberg" replay "recordings/$name.lcm" --lockstep --workers 1 --json "$out/$name.json" 2>&1 | grep -E 'state_hash|differs' || true
  python3 - "$out/$name.json" <<'END' || failed=1
import json, sys
c = json.load(open(sys.argv[1]))["checkpoints"]
print(c["equal"], "of", c["compared"], "checkpoints equal")
sys.exit(c["equal"] != c["compared"])
END
done
exit $failed
