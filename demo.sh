#!/usr/bin/env bash
# Renders models with soft shadows through a real server into demo_out/. Installs and builds first what is missing.
set -euo pipefail
cd "$(dirname "$0")"
export LC_ALL=C.UTF-8
source ./setup.sh

install_packages
build release halfshade halfshaded make_scene
bin=build/release
out=demo_out
mkdir -p "$out"
rm -f "$out"/*.png

log=$out/demo.log
fail() {
  echo "demo.sh: $1; the log ($log) ends with:" >&2
  tail -n 20 "$log" >&2
  exit 1
}

$bin/server/halfshaded --listen 127.0.0.1:0 >"$out/serving.txt" 2>"$log" &
server=$!
trap 'kill "$server" 2>/dev/null || true' EXIT
for _ in $(seq 300); do  # 30 s
  grep -q '^serving ' "$out/serving.txt" && break
  kill -0 "$server" 2>/dev/null || fail "the server did not start"
  sleep 0.1
done
address=$(sed -n 's/^serving grpc=\([^ ]*\).*/\1/p' "$out/serving.txt")
[ -n "$address" ] || fail "the server did not serve within 30 s"
echo "halfshaded serves on $address; every picture: a square light, 256 shadow maps"

# render NAME ARGUMENT...: a line with the report's time and shares, out of its JSON.
render() {
  local name=$1
  shift
  $bin/client/halfshade render --server "$address" "$@" --method multi_map --set k=256 --json -o "$out/$name.png" \
    >"$out/$name.json" 2>>"$log" || fail "$name was not rendered"
  [ -s "$out/$name.png" ] || fail "$name.png is not there"
  tr -d ' ",' <"$out/$name.json" | awk -F: -v path="$out/$name.png" '
    { field[$1] = $2 }
    END { printf "  %-24s %5.1f s   umbra %2.0f %%, penumbra %2.0f %%, lit %2.0f %%\n", path, field["totalMs"] / 1000,
          100 * field["umbra"], 100 * field["penumbra"], 100 * field["lit"] }'
}
render bunny /usr/share/glmark2/models/bunny.obj
render engine /usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb
for made in plant colonnade; do
  $bin/tests/support/make_scene "$made" "$out/$made.glb" --view "$out/$made.view.json"
  render "$made" "$out/$made.glb" --view "$out/$made.view.json"
done

trap - EXIT
kill -TERM "$server"
wait "$server" || fail "the server did not end cleanly"

echo
echo "The pictures:"
ls -1 "$PWD/$out"/*.png | sed 's/^/  /'
cat <<WORDS

Now your own file (.glb, .gltf or .obj), without a server:
  $bin/client/halfshade render FILE -o picture.png
or through one:
  $bin/server/halfshaded --listen 127.0.0.1:50051 &
  $bin/client/halfshade render FILE -o picture.png --server 127.0.0.1:50051
WORDS
