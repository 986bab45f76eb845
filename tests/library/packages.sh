#!/usr/bin/env bash
# The Debian packages: made, looked into, installed into an empty root, used there, and removed without a trace.
#
#   tests/library/packages.sh BUILD PYTHON_BUILD        Python's package where there is such a build (./do python)
#
# The root has no libraries of the system: dpkg does not look for the packages that are depended on, and programs use those of
# this machine; scripts run outside of it, and do nothing but ldconfig. Skipped (77) without dpkg-deb, dpkg-shlibdeps, or root
# rights.
set -euo pipefail
build=$1 python_build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "packages: $*" >&2; exit 1; }
skip() { printf 'packages_install_and_go: Skipped\n%s\n' "$*"; exit 77; }
for tool in dpkg dpkg-deb dpkg-shlibdeps; do command -v $tool >/dev/null || skip "needs $tool (Debian: dpkg-dev)"; done
[ "$(id -u)" = 0 ] || skip "needs root rights, to install into a root of its own"

pack() { (cd "$1" && cpack -G DEB -B "$work/made" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip "${@:2}") >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "cpack in $1"; }; }
pack "$build"
if [ -f "$python_build/python/limberg/__init__.py" ]; then pack "$python_build" -D CPACK_COMPONENTS_ALL=python; fi
mapfile -t debs < <(find "$work/made" -maxdepth 1 -name '*.deb' | sort)
names=$(for d in "${debs[@]}"; do dpkg-deb -f "$d" Package; done | sort | tr '\n' ' ')
case "$names" in
  "liblimberg-dev limberg limberg-data " | "liblimberg-dev limberg limberg-data python3-limberg ") ;;
  *) fail "other packages than expected: $names" ;;
esac
deb() { local d; for d in "${debs[@]}"; do [ "$(dpkg-deb -f "$d" Package)" = "$1" ] && echo "$d"; done; return 0; }

# Each file is in one package, where Debian wants it; what it depends on is said.
for d in "${debs[@]}"; do dpkg-deb --contents "$d" | awk '$1 !~ /^d/{print $6}'; done | sort >"$work/files"
files=$work/files
[ -z "$(uniq -d "$files")" ] || fail "in two packages: $(uniq -d "$files")"
if grep -v '^\./usr/' "$files"; then fail "outside of /usr"; fi
for file in ./usr/bin/limberg ./usr/share/limberg/app/scenes/rhomboid.toml ./usr/include/limberg/limberg.h; do
  grep -qx "$file" "$files" || fail "no $file"
done
grep -q 'cmake/Limberg/LimbergConfig.cmake$' "$files" || fail "no LimbergConfig.cmake"
grep -q '/sim/testing/\|CMakeFiles' "$files" && fail "files of tests or builds are packed"
dpkg-deb -f "$(deb limberg)" Depends | grep -q 'libc6.*limberg-data\|limberg-data.*libc6' || fail "what limberg depends on"
[ "$(dpkg-deb -f "$(deb limberg-data)" Architecture)" = all ] || fail "limberg-data is of one architecture"

root=$work/root
mkdir -p "$root"/var/lib/dpkg/{info,updates,triggers}
touch "$root"/var/lib/dpkg/{status,available}
dpkg --root="$root" --force-depends --force-script-chrootless --install "${debs[@]}" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "dpkg --install"; }
cd "$work"
ldd "$root/usr/bin/limberg" | grep "not found" && fail "a library is missing"
"$root/usr/bin/limberg" --version >/dev/null || fail "limberg --version"
"$root/usr/bin/limberg" check rhomboid >checked || "$root/usr/bin/limberg" check "$root/usr/share/limberg/app/scenes/rhomboid.toml" >checked || fail "limberg check"
# Found in the packages, from a folder that has nothing.
"$root/usr/bin/limberg" replay recordings/zplasty.lcm --json r.json >/dev/null 2>said || [ $? = 3 ] || fail "$(cat said)"
grep -q '"state_hash"' r.json || fail "no result of a replay"
if [ -n "$(deb python3-limberg)" ]; then
  PYTHONPATH=$root/usr/lib/python3/dist-packages /usr/bin/python3 -c '
import limberg
assert limberg.__file__.startswith("'"$root"'"), limberg.__file__
assert limberg.shipped_file("recordings/rhomboid.jsonl").startswith("'"$root"'"), limberg.shipped_file("recordings/rhomboid.jsonl")
w = limberg.World(limberg.open_scene("rhomboid"))
w.apply(limberg.incise(path=[[0, 0], [20, 0]], depth_mm=4))
' || fail "import limberg"
fi
dpkg --root="$root" --force-depends --force-script-chrootless --purge $names >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "dpkg --purge"; }
# (what Python compiled when it was imported is not the package's)
find "$root/usr" -name __pycache__ -prune -exec rm -r {} + 2>/dev/null || true
left=$(find "$root/usr" ! -type d 2>/dev/null || true)
[ -z "$left" ] || fail "left behind: $left"
echo "packages: $names"
