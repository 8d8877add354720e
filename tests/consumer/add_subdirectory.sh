#!/usr/bin/env bash
# Builds a tiny program in a project that takes this repository in by add_subdirectory, and runs it.
# Usage: tests/consumer/add_subdirectory.sh WORK_DIR [cmake OPTION...]     (WORK_DIR is emptied)
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$1"
shift
rm -rf -- "$work"
mkdir -p -- "$work"
# Not optimised: what counts is that it builds. Only the solver is compiled, the simulator is configured.
cmake -S "$source_dir/tests/consumer/add_subdirectory" -B "$work/build" -G Ninja -DREPOSITORY="$source_dir" \
  -DCMAKE_BUILD_TYPE=None "$@" >"$work/configure.log" 2>&1 || { cat "$work/configure.log" >&2; exit 1; }
cmake --build "$work/build" --target solver >"$work/build.log" 2>&1 || { cat "$work/build.log" >&2; exit 1; }
promised="$(sed -n '1s/.*Prints: //p' "$source_dir/examples/solver_minimal.cpp")"
[[ "$("$work/build/solver")" == "$promised" ]] || { printf 'solver does not print: %s\n' "$promised" >&2; exit 1; }
printf 'add_subdirectory: the program runs\n'
