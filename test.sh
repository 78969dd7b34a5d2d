#!/usr/bin/env bash
# Builds and runs the tests; the last line is "N passed, N failed" (", N skipped"). Installs first what is missing.
#   ./test.sh          the release build: every test that needs no more than this machine
#   ./test.sh --asan   then also units, threads and the service under ASan and UBSan
#   ./test.sh --long   then also: everything under ASan and UBSan, the server's threads under TSan, clang-tidy, buf lint, and
#                      the container's smoke test; what has no tool here is counted as skipped
set -euo pipefail
cd "$(dirname "$0")"
export LC_ALL=C.UTF-8
source ./setup.sh

case "${1:-}" in
  "" | --asan | --long) ;;
  *)
    sed -n '2,/^set/ s/^# \{0,1\}//p' "$0" >&2
    exit 64
    ;;
esac

passed=0
failed=0
skipped=0

# run_tests PRESET CTEST-ARGUMENT...: adds to the counts, from ctest's own words: its JUnit file calls a test whose program is
# absent "skipped".
run_tests() {
  local preset=$1
  shift
  local log="build/$preset-tests.log"
  local status=0
  ctest --test-dir "build/$preset" -j 2 --output-on-failure --no-tests=error "$@" 2>&1 | tee "$log" || status=$?
  local summary='^[0-9]*% tests passed, \([0-9]*\) tests\{0,1\} failed out of \([0-9]*\)$'
  local bad total not_run
  bad=$(sed -n "s/$summary/\1/p" "$log")
  total=$(sed -n "s/$summary/\2/p" "$log")
  not_run=$(grep -c '^[[:space:]]*[0-9]* - .* (Skipped)$' "$log" || true)
  if [ -z "$total" ] || { [ "$status" -ne 0 ] && [ "$bad" -eq 0 ]; }; then
    echo "FAILED: ctest in build/$preset (exit code $status)" >&2
    failed=$((failed + 1))
    return
  fi
  passed=$((passed + total - bad - not_run))
  failed=$((failed + bad))
  skipped=$((skipped + not_run))
}

# check NAME TOOL COMMAND...: one more that passes or fails, or is skipped where there is no TOOL.
check() {
  local name=$1 tool=$2
  shift 2
  if ! command -v "$tool" >/dev/null; then
    echo "SKIPPED: $name: no $tool here"
    skipped=$((skipped + 1))
  elif "$@"; then
    passed=$((passed + 1))
  else
    echo "FAILED: $name" >&2
    failed=$((failed + 1))
  fi
}

install_packages
build release
run_tests release

case "${1:-}" in
  --asan)
    build asan
    run_tests asan -L 'unit|threads|integration'
    ;;
  --long)
    build asan
    run_tests asan
    build tsan
    run_tests tsan -L threads
    check clang-tidy run-clang-tidy-14 run-clang-tidy-14 -quiet -p build/release "^$PWD/(renderer|server|client)/"
    check "buf lint" buf buf lint proto
    engine=docker
    command -v docker >/dev/null && docker info >/dev/null 2>&1 || engine=podman
    check "container smoke test" "$engine" docker/smoke_test.sh
    ;;
esac

echo "$passed passed, $failed failed$([ "$skipped" -eq 0 ] || echo ", $skipped skipped")"
[ "$failed" -eq 0 ]
