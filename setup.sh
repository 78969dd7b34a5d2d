# Sourced by demo.sh and test.sh: installs what packages.txt lists and is missing, and builds. Not a command of its own.

# Package names of packages.txt, one a line; with an argument, those marked [argument] alone.
packages() {
  grep -v '^#' packages.txt | grep -F "${1:+[$1]}" | awk 'NF {print $1}'
}

# Installs missing packages as root or through sudo, or prints the line to run and fails.
install_packages() {
  local missing=()
  local name
  for name in $(packages); do
    dpkg-query -W -f='${Status}' "$name" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$name")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  local install="apt-get install -y --no-install-recommends ${missing[*]}"
  local sudo=""
  if [ "$(id -u)" -ne 0 ]; then
    # Without a password, or with one where there is somebody to type it.
    if command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
      sudo=sudo
    else
      echo "These packages are missing. As root, run this line and start again:" >&2
      echo "  apt-get update && $install" >&2
      return 1
    fi
  fi
  echo "installing ${#missing[@]} packages: ${missing[*]}"
  mkdir -p build
  local log=build/install.log
  if ! { $sudo apt-get update && $sudo env DEBIAN_FRONTEND=noninteractive $install; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "the packages were not installed; all of it: $log" >&2
    return 1
  fi
}

# build PRESET [TARGET...]: configures and builds into build/PRESET.
build() {
  local preset=$1
  shift
  local log="build/$preset.log"
  mkdir -p build
  echo "building build/$preset (the first time takes minutes; tail -f $log shows how far it is)"
  if ! { cmake --preset "$preset" && cmake --build "build/$preset" ${@:+--target "$@"}; } >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "the build failed; all of it: $log" >&2
    return 1
  fi
}
