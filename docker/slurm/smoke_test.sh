#!/usr/bin/env bash
# A batch as a Slurm array of 8 on this machine alone, with kill -9 of slurmd and slurmctld in the middle: complete, and equal to
# an unbroken run. Needs Debian's slurm-wlm and a build; starts its own daemons on ports of its own and ends them.
#     docker/slurm/smoke_test.sh build/release
set -euo pipefail
build=$(realpath "${1:?the folder of a build}")
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
# until_holds SECONDS TEST: 1 where it does not hold in time.
until_holds() {
  for _ in $(seq "$(($1 * 5))"); do
    "$2" && return
    sleep 0.2
  done
  echo "not within $1 s: $2" >&2
  tail -n 20 "$work"/task-*.txt "$work"/slurmctld.log "$work"/slurmd.log >&2 || true
  return 1
}
is_idle() { [ "$(sinfo -h -o %T 2>/dev/null)" = idle ]; }
until_holds 30 is_idle

cd "$work"
for scene in plant colonnade S2; do "$build/tests/support/make_scene" "$scene" "$scene.glb" >/dev/null; done
cat >template.json <<'JSON'
{"id": "item", "scene": {"$choice": ["plant.glb", "colonnade.glb", "S2.glb"]}, "width": 160, "height": 90,
 "method": {"ray": {"rays": 64}}, "seed": {"$integer": [0, 100000]}, "outputs": [{"kind": "OUTPUT_KIND_VISIBILITY"}]}
JSON
"$HALFSHADE" sample template.json --count 160 >requests.jsonl
"$HALFSHADE" batch requests.jsonl -o unbroken 2>/dev/null

# An array with gaps would leave shards out: refused.
code=0
REQUESTS=r OUT=o SLURM_ARRAY_TASK_ID=3 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=7 SLURM_ARRAY_TASK_COUNT=3 \
  bash "$here/array.sbatch" 2>/dev/null || code=$?
[ "$code" -eq 64 ]

lines() { cat out/manifest.jsonl 2>/dev/null | wc -l; }
has_twenty() { [ "$(lines)" -ge 20 ]; }
REQUESTS=$work/requests.jsonl OUT=$work/out sbatch --array=0-7 --output="$work/task-%a.txt" "$here/array.sbatch"
until_holds 120 has_twenty
kill -9 "$node" "$controller"
{ wait "$node" "$controller" || true; } 2>/dev/null
before=$(lines)
start_controller
start_node
echo "slurmd and slurmctld were killed with $before of 160 items whole"
# A task that runs is sent back to the queue: its process ends, and it goes on where it was.
is_running() { task=$(squeue -h -t RUNNING -o %A 2>/dev/null | head -n 1); [ -n "$task" ]; }
until_holds 60 is_running
scontrol requeue "$task"
echo "a task was requeued with $(lines) of 160 items whole"
is_done() { [ -z "$(squeue -h 2>/dev/null || echo unknown)" ]; }
until_holds 300 is_done

[ "$(lines)" -eq 160 ] || { echo "$(lines) of 160 items" >&2; exit 1; }
digests() { sed 's/.*"id":"\([^"]*\)".*"pixelSha256":"\([0-9a-f]*\)".*/\1 \2/' "$1/manifest.jsonl" | sort; }
cmp <(digests unbroken) <(digests out)
[ "$(find out -name '*.part' | wc -l)" -eq 0 ]
echo "160 of 160 items whole, equal to an unbroken run"
