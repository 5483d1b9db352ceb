#!/usr/bin/env bash
# Installs, builds, runs every test, and those that need no server a second time under AddressSanitizer and UBSan, where
# each fuzz target looks for new inputs for ten seconds.
# The last line is "N passed, N failed" (", N skipped" if any); the exit status is 0 only if tests ran and none failed.
set -uo pipefail
cd "$(dirname "$0")/.."
source_dir=$PWD
jobs=$(nproc)
options=(-G Ninja)
if [ "${CI:-}" = true ]; then
    options+=(-DANYRATE_WERROR=ON)
fi
reports=()
broken=0  # steps that failed before any test could say so

# step TITLE COMMAND...: a command that must succeed for the tests to mean anything
step() {
    echo "== $1"
    shift
    "$@" || { echo "failed: $*"; broken=$((broken + 1)); return 1; }
}

# run_tests TITLE TEST_DIR: every test CTest knows there
run_tests() {
    local report=$source_dir/build/reports/${1// /-}.xml
    echo "== $1"
    ctest --test-dir "$2" --output-on-failure --parallel "$jobs" --timeout 1200 --no-tests=error --output-junit "$report" \
        --test-output-size-passed 10000000 --test-output-size-failed 10000000
    if [ -s "$report" ]; then reports+=("$report"); else broken=$((broken + 1)); fi
}

# npm ci deletes and fetches everything, so it runs only when the lock file is newer than what it left.
web_packages() {
    [ web/node_modules/.package-lock.json -nt web/package-lock.json ] || npm ci --prefix web --no-audit --no-fund
}

all_tests() {
    step "build" cmake --build build || return
    run_tests "tests" build
}

sanitized_tests() {
    step "build with sanitizers" cmake --build build-sanitized --target tests/all || return
    export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
    run_tests "sanitized tests" build-sanitized
}

step "install" bash docker/install.sh || { echo "0 passed, 1 failed"; exit 1; }
step "install web packages" web_packages
mkdir -p build/reports
rm -f build/reports/*.xml
step "configure" cmake -S . -B build "${options[@]}" -DCMAKE_BUILD_TYPE=Release && all_tests
# A debug build, so that assertions hold too, but optimised enough to end soon.
step "configure with sanitizers" cmake -S . -B build-sanitized "${options[@]}" -DCMAKE_BUILD_TYPE=Debug \
    -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1" -DANYRATE_SANITIZE=ON && sanitized_tests

read -r passed failed skipped < <(python3 tests/count.py "${reports[@]}")
failed=$((${failed:-1} + broken))
closing="${passed:-0} passed, $failed failed"
if [ "${skipped:-0}" -gt 0 ]; then closing+=", $skipped skipped"; fi
echo
echo "$closing"
[ "$failed" -eq 0 ] && [ "${passed:-0}" -gt 0 ]
