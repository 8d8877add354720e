#!/usr/bin/env bash
# Builds everything and runs all tests.
# Usage: scripts/test.sh [--sanitize]      --sanitize: afterwards once more with the address and undefined
#                                          behaviour sanitizers (takes several times as long)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

sanitize=no
for argument in "$@"; do
  case "$argument" in
    --sanitize) sanitize=yes ;;
    -h | --help) sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) printf 'test.sh: unknown argument %s (known: --sanitize)\n' "$argument" >&2; exit 2 ;;
  esac
done

run_preset() {
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "$(nproc)"
  ctest --preset "$1" --parallel "$(nproc)"
}

scripts/setup
run_preset release
if [[ $sanitize == yes ]]; then run_preset asan-ubsan; fi
