#!/usr/bin/env bash
# Renders models with soft shadows through a real server into demo_out/. Installs and builds what is missing first.
set -euo pipefail
cd "$(dirname "$0")"
source ./setup.sh

install_packages
build release halfshade halfshaded make_scene
bin=build/release
out=demo_out
mkdir -p "$out"

log="$out/halfshaded.log"
$bin/server/halfshaded --listen 127.0.0.1:0 >"$out/serving.txt" 2>"$log" &
server_pid=$!
trap 'kill "$server_pid" 2>/dev/null || true' EXIT
for _ in $(seq 300); do
  grep -q '^serving ' "$out/serving.txt" && break
  kill -0 "$server_pid" 2>/dev/null || { cat "$log" >&2; echo "the server did not start" >&2; exit 1; }
  sleep 0.1
done
address=$(sed -n 's/^serving grpc=\([^ ]*\).*/\1/p' "$out/serving.txt")
[ -n "$address" ] || { echo "the server did not come up within 30 s" >&2; exit 1; }
echo "halfshaded serves on $address"

render() {  # NAME ARGUMENT...
  local name=$1
  shift
  echo "rendering $name"
  $bin/client/halfshade render --server "$address" "$@" --method multi_map --set k=256 -o "$out/$name.png"
}
render bunny /usr/share/glmark2/models/bunny.obj
render engine /usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb
for made in plant colonnade; do
  $bin/tests/support/make_scene "$made" "$out/$made.glb" --view "$out/$made.view.json"
  render "$made" "$out/$made.glb" --view "$out/$made.view.json"
done

kill -TERM "$server_pid"
wait "$server_pid" || { echo "the server did not end cleanly" >&2; exit 1; }
trap - EXIT

echo
echo "Soft shadows of a square light, 256 shadow maps each:"
ls -1 "$PWD/$out"/*.png | sed 's/^/  /'
cat <<WORDS
Now your own file (.glb, .gltf or .obj), without a server:
  $bin/client/halfshade render FILE -o out.png
or on the server of your choice:
  $bin/server/halfshaded --listen 127.0.0.1:50051 &
  $bin/client/halfshade render FILE -o out.png --server 127.0.0.1:50051
WORDS
