#!/bin/bash
# study_on_cluster.sh LIMBERG: a study on a Slurm cluster of two nodes that this script starts (cluster.sh).
#
# 24 members. The program that submits is killed while they run, and the same call takes the study up again; then a node
# is stopped in the middle and stays away. Nothing may be lost, and every figure must be that of --engine local to the
# last bit. A member that takes too long fails in words. Ends with 77 where Slurm is missing.
set -u
limberg=$(readlink -f "$1")
cd "$(dirname "$0")"
. ./cluster.sh
cluster_or_skip

dir=$(mktemp -d "${TMPDIR:-/tmp}/limberg-slurm-XXXXXX")
trap 'cluster_stop; rm -rf "$dir"' EXIT
fail() { echo "FAILED: $*"; tail -n 40 "$dir"/err* "$dir"/on/progress.log "$dir"/on/tasks/*/*.log "$dir"/c/log/slurmctld.log 2>/dev/null; exit 1; }
members() { ls "$dir/on/members" 2>/dev/null | grep -c 'json$'; }
wait_for() {  # SECONDS MEMBERS
  local end=$((SECONDS + $1))
  until [ "$(members)" -ge "$2" ]; do [ $SECONDS -lt $end ] || fail "only $(members) members after $1 s"; sleep 0.05; done
}

study=(study tissue --set flap_angle=45,60 --set skin_kPa=30,60,120 --set prestretch=5,10 --set seed=0,1
  --set cell=10 --set halvings=1 --set skin_mm=4 --set contact=0 --set quick=1)
slurm=(--engine slurm --per-task 3 --limit 120 --out "$dir/on")

# Where no slurmctld answers: words, and the status of a wrong call.
SLURM_CONF=$dir/none.conf "$limberg" "${study[@]}" "${slurm[@]}" 2>"$dir/err0"
[ $? = 2 ] && grep -q "expected a cluster that runs" "$dir/err0" || fail "no cluster: $(cat "$dir/err0")"
rm -rf "$dir/on"

cluster_start "$dir/c" || fail "the cluster does not start"
echo "$CLUSTER_KIND"

# Whoever submits is killed; what the cluster has goes on.
"$limberg" "${study[@]}" "${slurm[@]}" >"$dir/out1" 2>"$dir/err1" &
submitter=$!
wait_for 120 2
kill -9 $submitter; wait $submitter 2>/dev/null

# Taken up again, by the same call; a node stops while it runs a task, and stays away.
"$limberg" "${study[@]}" "${slurm[@]}" >"$dir/out2" 2>"$dir/err2" &
submitter=$!
wait_for 120 $(($(members) + 2))
end=$((SECONDS + 60))
until [ "$(squeue -h -r -w node2 -t R -o %i | wc -l)" -gt 0 ]; do
  [ $SECONDS -lt $end ] && kill -0 $submitter 2>/dev/null || fail "nothing runs on node2"
  sleep 0.05
done
node_stop 2
at_stop=$(members)
echo "node2 stopped with $at_stop of 24 members there"
[ "$at_stop" -lt 24 ] || fail "the node stopped too late to tell anything"
# Slurm lets a task that a node has lost rest for two minutes; here nobody waits for that.
end=$((SECONDS + 120))
until [ "$(squeue -h -r -t PD -o %r | grep -c BeginTime)" -gt 0 ] || ! kill -0 $submitter 2>/dev/null; do
  [ $SECONDS -lt $end ] || fail "Slurm does not see that the node is gone"
  sleep 0.5
done
for task in $(squeue -h -r -t PD -o '%i %r' | awk '/BeginTime/ {print $1}'); do scontrol update JobId=$task StartTime=now; done
wait $submitter || fail "status $? after the node stopped"

[ "$(grep -c 'are waited for' "$dir/err2")" = 1 ] || fail "the second call did not take the first one's tasks up"
[ "$(ls -d "$dir"/on/tasks/* | wc -l)" = 1 ] || fail "members were submitted a second time"
grep -q "begun again" "$dir"/on/tasks/1/*.log || fail "no task was begun again on the other node"
[ "$(members)" = 24 ] || fail "$(members) of 24 members"
tail -n 1 "$dir/on/progress.log"
tail -n 1 "$dir/on/progress.log" | grep -q " 0 failed" || fail "members failed"

"$limberg" "${study[@]}" --out "$dir/here" >"$dir/out3" 2>"$dir/err3" || fail "status $? of --engine local"
cmp "$dir/on/rows.csv" "$dir/here/rows.csv" || fail "figures differ from those of --engine local"
[ "$(wc -l <"$dir/here/rows.csv")" = 25 ] || fail "not 24 rows"

# The same call again finds everything there, and asks for nothing.
"$limberg" "${study[@]}" "${slurm[@]}" >"$dir/out4" 2>"$dir/err4" || fail "status $? of the third call"
grep -q "24 members are there already" "$dir/err4" || fail "the third call ran members again"

# Too slow: failed, counted, in words.
"$limberg" study tissue --set cell=10 --engine slurm --limit 0.01 --retries 1 --out "$dir/slow" >"$dir/out5" 2>"$dir/err5"
[ $? = 3 ] || fail "a member that is too slow"
grep -q "took longer than 0.01 s" "$dir/err5" || fail "no words of it: $(cat "$dir/err5")"
grep -q "1 tried again" "$dir/slow/progress.log" || fail "it was not tried again"
echo "24 members on two nodes, one of them stopped: none lost, figures as on this machine"
