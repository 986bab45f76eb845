# A Slurm cluster of two nodes on one machine, for tests: to be sourced.
#
#   cluster_or_skip            ends with 77 and a line of why where Slurm's packages are missing
#   cluster_start FOLDER       starts munged, slurmctld and two slurmd in that folder; CLUSTER_KIND says how
#   node_stop N                node N (1 or 2) as if its plug were pulled: its slurmd and all that runs on it, SIGKILL
#   node_start N
#   cluster_stop               ends everything and takes the network away
#
# With root rights each node has a network namespace of its own with an address of its own, joined by a bridge, so that
# slurmctld reaches it over a (virtual) wire and a node that stops takes its connections with it. Without, or where the
# kernel has no bridges, both slurmd run beside each other under their own names and ports ("multiple slurmd"). Slurm
# believes each node to have one core (CLUSTER_CPUS).

cluster_or_skip() {
  local missing=() p
  for p in munged slurmctld slurmd sbatch squeue scontrol; do
    PATH=$PATH:/usr/sbin:/sbin command -v $p >/dev/null || missing+=($p)
  done
  if [ ${#missing[@]} -gt 0 ]; then
    echo "no ${missing[*]}; expected Debian's packages slurmctld, slurmd, slurm-client, munge (./do cluster installs them)"
    exit 77
  fi
  export PATH=$PATH:/usr/sbin:/sbin
}

_namespaces() {
  [ -z "${CLUSTER_PLAIN:-}" ] && [ "$(id -u)" = 0 ] && command -v ip >/dev/null || return 1
  NET=limb$$
  ip netns add ${NET}1 2>/dev/null && ip netns add ${NET}2 2>/dev/null &&
    ip link add ${NET}b type bridge 2>/dev/null && ip addr add 10.213.77.1/24 dev ${NET}b 2>/dev/null &&
    ip link set ${NET}b up || return 1
  local n
  for n in 1 2; do
    ip link add ${NET}v$n type veth peer name eth0 netns $NET$n 2>/dev/null && ip link set ${NET}v$n master ${NET}b up &&
      ip -n $NET$n addr add 10.213.77.1$n/24 dev eth0 && ip -n $NET$n link set eth0 up &&
      ip -n $NET$n link set lo up || return 1
  done
}

_no_namespaces() {
  local n
  for n in 1 2; do ip netns del $NET$n 2>/dev/null; ip link del ${NET}v$n 2>/dev/null; done
  ip link del ${NET}b 2>/dev/null
  return 0
}

_until() {  # SECONDS COMMAND...
  local end=$((SECONDS + $1)); shift
  until "$@" >/dev/null 2>&1; do [ $SECONDS -lt $end ] || return 1; sleep 0.3; done
}

cluster_start() {
  C=$1 NODE_PIDS=("" "" "")
  mkdir -p "$C"/{state,spool-node1,spool-node2,log}
  local user; user=$(id -un)
  # slurmctld's port: free ones, so that two runs do not meet.
  PORT=$((20000 + $$ % 20000))
  if _namespaces; then
    CLUSTER_KIND="two nodes in network namespaces"
    nodes="NodeName=node1 NodeHostname=node1 NodeAddr=10.213.77.11 Port=$((PORT + 1))
NodeName=node2 NodeHostname=node2 NodeAddr=10.213.77.12 Port=$((PORT + 2))"
    controller="SlurmctldHost=$(hostname)(10.213.77.1)"
  else
    _no_namespaces
    NET=
    CLUSTER_KIND="two slurmd on one host (no network namespaces here)"
    nodes="NodeName=node1 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((PORT + 1))
NodeName=node2 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((PORT + 2))"
    controller="SlurmctldHost=$(hostname)(127.0.0.1)"
  fi
  nodes=$(printf '%s\n' "$nodes" | sed "s/$/ CPUs=${CLUSTER_CPUS:-1} RealMemory=2000 State=UNKNOWN/")
  dd if=/dev/urandom of="$C/munge.key" bs=128 count=1 status=none; chmod 600 "$C/munge.key"
  munged --foreground --force --key-file="$C/munge.key" --socket="$C/munge.socket" --pid-file="$C/munge.pid" \
    --log-file="$C/log/munged.log" --seed-file="$C/munge.seed" --num-threads=2 >"$C/log/munged.out" 2>&1 &
  MUNGE_PID=$!
  cat >"$C/slurm.conf" <<CONF
ClusterName=limberg
$controller
SlurmUser=$user
SlurmdUser=$user
SlurmctldPort=$PORT
AuthType=auth/munge
AuthInfo=socket=$C/munge.socket
CryptoType=crypto/munge
CredType=cred/munge
StateSaveLocation=$C/state
SlurmdSpoolDir=$C/spool-%n
SlurmctldPidFile=$C/slurmctld.pid
SlurmdPidFile=$C/slurmd-%n.pid
SlurmctldLogFile=$C/log/slurmctld.log
SlurmdLogFile=$C/log/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,bf_interval=5,batch_sched_delay=1
ReturnToService=2
SlurmctldTimeout=10
SlurmdTimeout=10
InactiveLimit=0
KillWait=5
MinJobAge=10
MpiDefault=none
SwitchType=switch/none
$nodes
PartitionName=all Nodes=node1,node2 Default=YES MaxTime=INFINITE State=UP
CONF
  sed -i '/^CryptoType/d' "$C/slurm.conf"
  export SLURM_CONF="$C/slurm.conf"
  _until 20 test -S "$C/munge.socket" || { echo "munged does not start"; cat "$C/log/munged.out"; return 1; }
  slurmctld -D -f "$SLURM_CONF" >"$C/log/slurmctld.out" 2>&1 &
  CONTROLLER_PID=$!
  node_start 1; node_start 2
  _until 60 _both_up || { echo "the nodes do not come up"; tail -n 5 "$C"/log/*; return 1; }
}

_both_up() { [ "$(sinfo -h -N -o %t | grep -c '^\(idle\|mix\|alloc\)$')" = 2 ]; }

node_start() {
  if [ -n "$NET" ]; then
    # (ip netns exec would hide the control groups that slurmd asks for)
    nsenter --net=/run/netns/$NET$1 slurmd -D -N node$1 -f "$SLURM_CONF" >"$C/log/slurmd$1.out" 2>&1 &
  else
    setsid slurmd -D -N node$1 -f "$SLURM_CONF" >"$C/log/slurmd$1.out" 2>&1 &
  fi
  NODE_PIDS[$1]=$!
}

# Those that descend from a process, itself first.
_tree() { echo "$1"; local c; for c in $(pgrep -P "$1"); do _tree "$c"; done; }

_of_node() {
  if [ -n "$NET" ]; then ip netns pids $NET$1; return; fi
  _tree ${NODE_PIDS[$1]}
  # Its steps, which are no children of slurmd any more, say the node's name in their title.
  local s
  for s in $(pgrep -f "slurmstepd: .*"); do
    tr '\0' '\n' <"/proc/$s/environ" 2>/dev/null | grep -q "^SLURM_CONF=$SLURM_CONF$" &&
      [ "$(ls -l /proc/$s/fd 2>/dev/null | grep -c "node$1")" -gt 0 ] && _tree $s
  done
}

node_stop() {
  local pids; pids=$(_of_node $1)
  [ -n "$pids" ] && kill -9 $pids 2>/dev/null
  wait ${NODE_PIDS[$1]} 2>/dev/null
  return 0
}

cluster_stop() {
  node_stop 1; node_stop 2
  [ -z "$CONTROLLER_PID" ] || { kill $CONTROLLER_PID 2>/dev/null; wait $CONTROLLER_PID 2>/dev/null; }
  [ -z "$MUNGE_PID" ] || { kill $MUNGE_PID 2>/dev/null; wait $MUNGE_PID 2>/dev/null; }
  [ -z "$NET" ] || _no_namespaces
  return 0
}
