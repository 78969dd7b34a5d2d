#!/usr/bin/env bash
# Builds the image and uses it fenced in: as uid 1000, root read-only, no capabilities, no network but loopback, 512 MB of memory,
# half a CPU. A picture, the server with its health, a batch through that server. Needs docker, or podman with runc (as root).
#   HALFSHADE_IMAGE=NAME  use that image instead of building one
set -euo pipefail
cd "$(dirname "$0")/.."

if command -v docker >/dev/null && docker info >/dev/null 2>&1; then
  engine=(docker)
  build=(docker build)
elif command -v podman >/dev/null; then
  engine=(podman --runtime runc)
  build=(podman --runtime runc build --network=host --isolation=chroot --format docker)
else
  echo "neither docker nor podman is here" >&2
  exit 1
fi
version=$(sed -n 's/^project(halfshade VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
image=${HALFSHADE_IMAGE:-}
if [ -z "$image" ]; then
  image=localhost/halfshade
  "${build[@]}" --build-arg "VERSION=$version" -t "$image" -f docker/Dockerfile .
fi

work=$(mktemp -d)
name=halfshade-smoke-$$
trap '"${engine[@]}" rm -f "$name" >/dev/null 2>&1 || true; rm -rf "$work"' EXIT
mkdir "$work/out"
chmod 755 "$work"
chmod 777 "$work/out"
fenced=(run --rm --no-healthcheck --read-only --tmpfs /tmp --cap-drop=all --security-opt no-new-privileges --user 1000:1000
        --ulimit nofile=20000:20000 --ulimit nproc=4096:4096 --memory 512m --cpus 0.5 -v "$work:/work")
since() { echo $((($(date +%s%N) - $1) / 1000000)); }
alone() { "${engine[@]}" "${fenced[@]}" --network none "$image" "$@"; }
beside() { "${engine[@]}" "${fenced[@]}" --network "container:$name" "$image" "$@"; }
inspect() { "${engine[@]}" image inspect -f "$1" "$image"; }

# A plate over a floor: one square, twice.
cat >"$work/plate.gltf" <<'GLTF'
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
 "nodes":[{"mesh":0,"scale":[4,1,4]},{"mesh":0,"translation":[0,0.8,0]}],
 "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
 "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
              {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
 "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
 "buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,AACAvwAAAAAAAIC/AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AACAPwAAAAAAAIC/AAABAAIAAAACAAMA"}]}
GLTF
for i in $(seq 24); do
  echo "{\"id\": \"item-$i\", \"scene\": \"plate.gltf\", \"width\": 320, \"height\": 180, \"seed\": $i,
         \"method\": {\"ray\": {\"rays\": 64}}, \"outputs\": [{\"kind\": \"OUTPUT_KIND_FRAME\"}, {\"kind\": \"OUTPUT_KIND_VISIBILITY\"}]}" |
    tr -d '\n'
  echo
done >"$work/requests.jsonl"
# "item-7 <digests of its pictures>", a line each.
digests() {
  awk '{ out = ""; while (match($0, /"(id|pixelSha256)":"[^"]*"/)) { out = out " " substr($0, RSTART, RLENGTH); $0 = substr($0, RSTART + RLENGTH) }
         print out }' "$1" | sort
}

echo "image: $(($(inspect '{{.Size}}') / 1000000)) MB, version $(inspect '{{index .Config.Labels "org.opencontainers.image.version"}}')"
[ "$(inspect '{{index .Config.Labels "org.opencontainers.image.version"}}')" = "$version" ]
inspect '{{json .Config.Healthcheck.Test}}' | grep -qF '"halfshade","health"'

begin=$(date +%s%N)
alone halfshade render /work/plate.gltf -o /work/out/plate.png --size 320x180
# Magic, then the header chunk with 320 x 180.
head -c 24 "$work/out/plate.png" | cmp - <(printf '\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x01\x40\0\0\0\xb4')
echo "render: 320 x 180 in $(since "$begin") ms, $(stat -c %s "$work/out/plate.png") bytes of uid $(stat -c %u "$work/out/plate.png")"

# README.md's job for a CI: the picture is the one that was agreed on; and one that is not fails.
cp "$work/plate.gltf" "$work/out/scene.gltf"
job=$(sed -n '/^ *halfshade render scene.glb/,/^ *python3/p' README.md | sed 's/scene.glb/scene.gltf/; s/^ *//')
[ "$(wc -l <<<"$job")" -eq 3 ]
in_ci() (
  cd "$work/out"
  halfshade() { "${engine[@]}" "${fenced[@]}" --network none -w /work/out "$image" halfshade "$@"; }
  eval "set -e; $job"
)
alone halfshade render /work/plate.gltf -o /work/out/agreed.png --max-error 0.01
in_ci
alone halfshade render /work/plate.gltf -o /work/out/agreed.png --camera "eye=1,5,4 target=0,0,0"
! in_ci 2>/dev/null
echo "README.md's CI job: passes with its picture, fails with another"

# The image's own command: loopback, port 50051, of a network of its own.
begin=$(date +%s%N)
"${engine[@]}" "${fenced[@]}" --network none --name "$name" "$image" >"$work/serving.txt" &
server=$!
for _ in $(seq 600); do  # 60 s
  grep -q '^serving ' "$work/serving.txt" && break
  kill -0 "$server" 2>/dev/null || { echo "the server did not start" >&2; exit 1; }
  sleep 0.1
done
grep -q '^serving grpc=127.0.0.1:50051 ' "$work/serving.txt" || { echo "the server did not serve within 60 s" >&2; exit 1; }
echo "start to SERVING: $(since "$begin") ms"
[ "$("${engine[@]}" exec "$name" halfshade health --server 127.0.0.1:50051)" = SERVING ]

# A batch that asks it, and the same again: nothing is left to do. Then in one process: the same pixels.
begin=$(date +%s%N)
beside halfshade batch /work/requests.jsonl -o /work/out/asked --server 127.0.0.1:50051
echo "batch: 24 items of 320 x 180, two pictures each, through the server in $(since "$begin") ms"
beside halfshade batch /work/requests.jsonl -o /work/out/asked --server 127.0.0.1:50051 --resume --json >"$work/summary.json"
grep -q '"wholeBefore": 24' "$work/summary.json"
alone halfshade batch /work/requests.jsonl -o /work/out/alone
[ "$(wc -l <"$work/out/asked/manifest.jsonl")" -eq 24 ]
cmp <(digests "$work/out/asked/manifest.jsonl") <(digests "$work/out/alone/manifest.jsonl")
peak_mb=$("${engine[@]}" exec "$name" awk '/^VmHWM:/ {print int($2 / 1000)}' /proc/1/status)
[ "$peak_mb" -gt 0 ]
echo "server: at most $peak_mb MB of its own"
"${engine[@]}" stop -t 10 "$name" >/dev/null
wait "$server" || { echo "the server did not end cleanly" >&2; exit 1; }
echo "smoke test passed"
