#!/usr/bin/env bash
# A batch as a Slurm array of 8 on this machine alone, with kill -9 of slurmd and slurmctld in the middle: complete, and equal to
# an unbroken run. Needs Debian's slurm-wlm and a build; starts its own daemons on ports of its own and ends them.
#     docker/slurm/smoke_test.sh build/release
set -euo pipefail
build=$(realpath "${1:?the build's folder}")
here=$(realpath "$(dirname "$0")")
export HALFSHADE=$build/client/halfshade
work=$(mktemp -d)
controller= node=
stop() {
  scancel --user="$(id -un)" 2>/dev/null || true
  sleep 1
  for pid in $node $controller; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}

# Slurm on one machine, without root's services: no authentication, no cgroups.
export SLURM_CONF=$work/slurm.conf
mkdir "$work/state" "$work/spool"
cat >"$SLURM_CONF" <<CONF
ClusterName=smoke
SlurmctldHost=localhost
SlurmctldPort=27817
SlurmdPort=27818
AuthType=auth/none
CredType=cred/none
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobRequeue=1
ReturnToService=2
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
MpiDefault=none
NodeName=localhost CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
start_controller() { slurmctld -D -f "$SLURM_CONF" >/dev/null 2>&1 & controller=$!; }
start_node() { slurmd -D -N localhost -f "$SLURM_CONF" >/dev/null 2>&1 & node=$!; }
trap stop EXIT
start_controller
start_node
for _ in $(seq 100); do
  [ "$(sinfo -h -o %T 2>/dev/null)" = idle ] && break
  sleep 0.2
done
sinfo

cd "$work"
for scene in plant colonnade S2; do "$build/tests/support/make_scene" "$scene" "$scene.glb" >/dev/null; done
cat >template.json <<'JSON'
{"id": "item", "scene": {"$choice": ["plant.glb", "colonnade.glb", "S2.glb"]}, "width": 160, "height": 90,
 "method": {"ray": {"rays": 64}}, "seed": {"$integer": [0, 100000]}, "outputs": [{"kind": "OUTPUT_KIND_VISIBILITY"}]}
JSON
"$HALFSHADE" sample template.json --count 160 >requests.jsonl
"$HALFSHADE" batch requests.jsonl -o unbroken 2>/dev/null

lines() { cat out/manifest.jsonl 2>/dev/null | wc -l; }
REQUESTS=$work/requests.jsonl OUT=$work/out sbatch --array=0-7 --output="$work/task-%a.txt" "$here/array.sbatch"
for _ in $(seq 600); do
  [ "$(lines)" -ge 20 ] && break
  sleep 0.1
done
before=$(lines)
kill -9 "$node" "$controller"
wait "$node" "$controller" 2>/dev/null || true
start_controller
start_node
echo "slurmd and slurmctld were killed with $before of 160 items whole"
# A task that runs is killed too: Slurm requeues it, and it goes on.
sleep 2
task=$(squeue -h -t RUNNING -o %A 2>/dev/null | head -n 1)
[ -z "$task" ] || scontrol requeue "$task" || true
for _ in $(seq 1500); do
  [ -z "$(squeue -h 2>/dev/null || echo '?')" ] && break
  sleep 0.2
done

[ "$(lines)" -eq 160 ] || { cat task-*.txt >&2; tail slurmctld.log slurmd.log >&2; echo "$(lines) of 160 items" >&2; exit 1; }
digests() { sed 's/.*"id":"\([^"]*\)".*"pixelSha256":"\([0-9a-f]*\)".*/\1 \2/' "$1/manifest.jsonl" | sort; }
cmp <(digests unbroken) <(digests out)
[ "$(find out -name '*.part' | wc -l)" -eq 0 ]
echo "160 of 160 items whole, equal to an unbroken run"
