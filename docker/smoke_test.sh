#!/usr/bin/env bash
# Builds the image and renders one PNG and a batch in it as uid 1000, with a read-only root, no capabilities, 512 MB of memory and
# half a CPU; then starts the server in it and asks for its health. Needs docker, or podman with runc (as root).
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
image=${HALFSHADE_IMAGE:-}
if [ -z "$image" ]; then
  image=localhost/halfshade
  version=$(sed -n 's/^project(halfshade VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
  "${build[@]}" --build-arg "VERSION=$version" -t "$image" -f docker/Dockerfile .
fi

work=$(mktemp -d)
name=halfshade-smoke-$$
trap '"${engine[@]}" rm -f "$name" >/dev/null 2>&1 || true; rm -rf "$work"' EXIT
# A scene that needs no file but this one: a triangle.
cat >"$work/triangle.gltf" <<'GLTF'
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
 "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
 "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
 "bufferViews":[{"buffer":0,"byteLength":36}],
 "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
GLTF
mkdir "$work/out"
chmod 755 "$work"
chmod 777 "$work/out"
fenced=(run --rm --no-healthcheck --network=host --read-only --tmpfs /tmp --cap-drop=all --security-opt no-new-privileges --user 1000:1000
        --ulimit nofile=20000:20000 --ulimit nproc=4096:4096)

"${engine[@]}" "${fenced[@]}" -v "$work:/work" "$image" halfshade render /work/triangle.gltf -o /work/out/triangle.png --size 320x180
# Magic, then the header chunk with 320 x 180.
head -c 24 "$work/out/triangle.png" | cmp - <(printf '\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x01\x40\0\0\0\xb4')
echo "rendered 320 x 180 in $(stat -c %s "$work/out/triangle.png") bytes as uid $(stat -c %u "$work/out/triangle.png")," \
     "root read-only, no capabilities"

# A batch, its folder on a volume, and the same again: nothing is left to do.
for i in 1 2 3 4 5 6; do
  echo "{\"id\": \"item-$i\", \"scene\": \"triangle.gltf\", \"width\": 64, \"height\": 36, \"seed\": $i}"
done >"$work/requests.jsonl"
limits=()
"${engine[@]}" "${fenced[@]}" --memory 512m --cpus 0.5 "$image" true 2>/dev/null && limits=(--memory 512m --cpus 0.5)
[ ${#limits[@]} -gt 0 ] || echo "this engine cannot limit memory and CPU: the batch runs without"
for _ in 1 2; do
  "${engine[@]}" "${fenced[@]}" "${limits[@]}" -v "$work:/work" "$image" \
    halfshade batch /work/requests.jsonl -o /work/out/batch --resume --json >"$work/summary.json"
done
grep -q '"wholeBefore": 6' "$work/summary.json"
[ "$(wc -l <"$work/out/batch/manifest.jsonl")" -eq 6 ]
echo "a batch of 6 items${limits[*]:+ with ${limits[*]}}, and resumed with nothing to do"

begin=$(date +%s%N)
"${engine[@]}" "${fenced[@]}" --name "$name" "$image" halfshaded --listen 127.0.0.1:0 >"$work/serving.txt" &
server=$!
for _ in $(seq 600); do  # 60 s
  grep -q '^serving ' "$work/serving.txt" && break
  kill -0 "$server" 2>/dev/null || { echo "the server did not start" >&2; exit 1; }
  sleep 0.1
done
address=$(sed -n 's/^serving grpc=\([^ ]*\).*/\1/p' "$work/serving.txt")
[ -n "$address" ] || { echo "the server did not serve within 60 s" >&2; exit 1; }
echo "start to SERVING: $((($(date +%s%N) - begin) / 1000000)) ms"
"${engine[@]}" "${fenced[@]}" "$image" halfshade health --server "$address"
"${engine[@]}" stop -t 10 "$name" >/dev/null
wait "$server" || { echo "the server did not end cleanly" >&2; exit 1; }
echo "image: $(($("${engine[@]}" image inspect -f '{{.Size}}' "$image") / 1000000)) MB"
echo "smoke test passed"
