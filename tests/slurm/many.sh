#!/bin/bash
# many.sh LIMBERG FOLDER: 2,048 small members on a Slurm cluster of two nodes that this script starts (cluster.sh); not
# run by ctest, since it takes a quarter of an hour. What docs/cluster.md says of it was read from what it prints.
#
# Rhomboid flaps of two angles; stiffness, prestretch, thickness, Poisson's ratio, fat and seed drawn from facial-skin.
# Node 2 is stopped when two fifths of the members are there, and comes back when three fifths are.
set -u
limberg=$(readlink -f "$1") out=$2
cd "$(dirname "$0")"
. ./cluster.sh
cluster_or_skip
mkdir -p "$out"
out=$(readlink -f "$out")
dir=$(mktemp -d "${TMPDIR:-/tmp}/limberg-slurm-XXXXXX")
trap 'cluster_stop; rm -rf "$dir"' EXIT
members() { ls "$out/members" 2>/dev/null | grep -c 'json$'; }
study=(study tissue --sample sobol ${POINTS:-128} --sensitivity --ranges facial-skin --set flap_angle=45,60
  --set cell=10 --set halvings=2 --set skin_mm=4 --set contact=0 --set quick=1)
all=$((${POINTS:-128} * 8 * 2))

cluster_start "$dir/c" || exit 1
echo "$CLUSTER_KIND; load before: $(cut -d' ' -f1-3 /proc/loadavg)"
start=$SECONDS
"$limberg" "${study[@]}" --engine slurm --limit 120 --out "$out" >"$out/printed" 2>"$out/said" &
submitter=$!
reached() { [ "$(members)" -ge $1 ] || ! kill -0 $submitter 2>/dev/null; }
until reached $((all * 2 / 5)); do sleep 1; done
until [ "$(squeue -h -r -w node2 -t R -o %i | wc -l)" -gt 0 ]; do sleep 0.2; done
echo "after $((SECONDS - start)) s: node2 runs task $(squeue -h -r -w node2 -t R -o %K) and is stopped with $(members) members there"
node_stop 2
until reached $((all * 3 / 5)); do sleep 1; done
echo "after $((SECONDS - start)) s: $(members) members there; node2 is $(sinfo -h -N -n node2 -o %t), and started again; load $(cut -d' ' -f1-3 /proc/loadavg)"
node_start 2
wait $submitter
status=$?
echo "after $((SECONDS - start)) s: status $status, $(members) members; load $(cut -d' ' -f1-3 /proc/loadavg)"
echo "tasks: $(ls "$out"/tasks/1 | grep -c '^[0-9]*$') in $(ls -d "$out"/tasks/* | wc -l) arrays; begun again: $(grep -l 'begun again' "$out"/tasks/*/*.log | wc -l)"
for n in 1 2; do echo "on node$n: $(grep -l "on node$n[,:]" "$out"/tasks/*/*.log | wc -l) tasks"; done
tail -n 1 "$out/progress.log"
awk -F: '/"seconds"/ {s += $2; n++} END {printf "seconds of the members: %.0f together, %.2f each\n", s, s / n}' "$out"/members/*.json
exit $status
