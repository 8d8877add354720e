#!/usr/bin/env bash
# Builds a tiny program in a project that takes this repository in by add_subdirectory, and runs it.
# Usage: tests/consumer/add_subdirectory.sh WORK_DIR [cmake OPTION...]     (WORK_DIR is emptied)
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$1"
shift
rm -rf -- "$work"
mkdir -p -- "$work"
# Not optimised, for one instruction set: what counts is that it builds. Only the solver is compiled, the simulator is
# configured. And without the packages that bring more orderings, which must be said.
cmake -S "$source_dir/tests/consumer/add_subdirectory" -B "$work/build" -G Ninja -DREPOSITORY="$source_dir" \
  -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC \
  -DCMAKE_DISABLE_FIND_PACKAGE_METIS=ON -DCMAKE_DISABLE_FIND_PACKAGE_SuiteSparse=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON "$@" >"$work/configure.log" 2>&1 || { cat "$work/configure.log" >&2; exit 1; }
for package in METIS SuiteSparse Boost; do
  grep -q "without these orderings.*$package" "$work/configure.log" ||
    { printf 'nothing is said of the orderings that miss with %s\n' "$package" >&2; exit 1; }
done
cmake --build "$work/build" --target solver >"$work/build.log" 2>&1 || { cat "$work/build.log" >&2; exit 1; }
promised="$(sed -n '1s/.*Prints: //p' "$source_dir/examples/solver_minimal.cpp")"
[[ "$("$work/build/solver")" == "$promised" ]] || { printf 'solver does not print: %s\n' "$promised" >&2; exit 1; }
printf 'add_subdirectory: the program runs\n'
