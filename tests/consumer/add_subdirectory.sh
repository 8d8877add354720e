#!/usr/bin/env bash
# Builds a tiny program in a project that takes this repository in by add_subdirectory, and runs it.
# Usage: tests/consumer/add_subdirectory.sh WORK_DIR [cmake OPTION...]     (WORK_DIR is emptied)
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$1"
shift
rm -rf -- "$work"
mkdir -p -- "$work"
fail() { printf 'add_subdirectory: %s\n' "$*" >&2; exit 1; }
configure() {  # NAME [OPTION...]
  local log="$work/$1.log"
  shift
  cmake -S "$source_dir/tests/consumer/add_subdirectory" -B "$work/build" -G Ninja "$@" >"$log" 2>&1 ||
    { cat "$log" >&2; exit 1; }
}
has() { grep -q "^$1:" <<<"$(cmake --build "$work/build" --target help)"; }

# Not optimised, for one instruction set: what counts is that it builds. And without the packages that bring more
# orderings, which must be said.
configure with_physics -DREPOSITORY="$source_dir" -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC \
  -DCMAKE_DISABLE_FIND_PACKAGE_METIS=ON -DCMAKE_DISABLE_FIND_PACKAGE_SuiteSparse=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON "$@"
for package in METIS SuiteSparse Boost; do
  grep -q "without these orderings.*$package" "$work/with_physics.log" ||
    fail "nothing is said of the orderings that miss with $package"
done
has physics || fail "the simulator is left out"

# The simulator was configured. What is compiled is the solver as it is without: the packages that only the simulator
# needs are not looked for.
configure solver_only -DGRAPHSOLVE_BUILD_PHYSICS=OFF -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_tomlplusplus=ON -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON
! has physics || fail "GRAPHSOLVE_BUILD_PHYSICS=OFF does not leave the simulator out"
cmake --build "$work/build" --target solver >"$work/build.log" 2>&1 || { cat "$work/build.log" >&2; exit 1; }
promised="$(sed -n '1s/.*Prints: //p' "$source_dir/examples/solver_minimal.cpp")"
[[ "$("$work/build/solver")" == "$promised" ]] || fail "solver does not print: $promised"
printf 'add_subdirectory: the program runs\n'
