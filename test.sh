#!/usr/bin/env bash
# Builds and runs the tests; the last line is "N passed, N failed". Installs what is missing first.
#   ./test.sh            release build, every test that needs no more than this machine
#   ./test.sh --long     then also: ASan and UBSan on everything, TSan on the server's own threads, clang-format,
#                        clang-tidy, buf lint (where they are installed), and the container's smoke test
set -euo pipefail
cd "$(dirname "$0")"
source ./setup.sh

passed=0
failed=0
skipped=0

# run_tests PRESET CTEST-ARGUMENT...: adds to the counts.
run_tests() {
  local preset=$1
  shift
  local junit="$PWD/build/$preset/tests.xml"
  rm -f "$junit"
  ctest --test-dir "build/$preset" -j 2 --output-on-failure --no-tests=error --output-junit "$junit" "$@" || true
  local head
  head=$(grep -m1 -A8 '<testsuite' "$junit" | tr '\n' ' ')
  local total bad skip disabled
  total=$(sed -n 's/.*tests="\([0-9]*\)".*/\1/p' <<<"$head")
  bad=$(sed -n 's/.*failures="\([0-9]*\)".*/\1/p' <<<"$head")
  disabled=$(sed -n 's/.*disabled="\([0-9]*\)".*/\1/p' <<<"$head")
  skip=$(sed -n 's/.*skipped="\([0-9]*\)".*/\1/p' <<<"$head")
  [ "${total:-0}" -gt 0 ] || bad=1
  skip=$((${skip:-0} + ${disabled:-0}))
  passed=$((passed + total - bad - skip))
  failed=$((failed + bad))
  skipped=$((skipped + skip))
}

# check NAME COMMAND...: one more that passes or fails.
check() {
  local name=$1
  shift
  if "$@"; then
    passed=$((passed + 1))
  else
    echo "FAILED: $name" >&2
    failed=$((failed + 1))
  fi
}

install_packages
build release
run_tests release

if [ "${1:-}" = "--long" ]; then
  sources=$(git ls-files '*.cc' '*.h')
  build asan
  run_tests asan
  build tsan
  run_tests tsan -L threads
  command -v clang-format >/dev/null && check clang-format clang-format --dry-run --Werror $sources
  command -v clang-tidy >/dev/null &&
    check clang-tidy sh -c "git ls-files '*.cc' | grep -v '^tests/' | xargs -P 2 -n 4 clang-tidy -p build/release --quiet"
  command -v buf >/dev/null && check "buf lint" sh -c "cd proto && buf lint"
  check "container smoke test" docker/smoke_test.sh
fi

if [ "$skipped" -gt 0 ]; then
  echo "$passed passed, $failed failed, $skipped skipped"
else
  echo "$passed passed, $failed failed"
fi
[ "$failed" -eq 0 ]
