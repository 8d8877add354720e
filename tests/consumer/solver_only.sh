#!/usr/bin/env bash
# GRAPHSOLVE_BUILD_PHYSICS=OFF: configures the repository as a part of another project and by itself, both without the
# packages that only the simulator and the program need, and asks the installed CMake package for what it has not.
# Compiles nothing. Usage: tests/consumer/solver_only.sh WORK_DIR     (WORK_DIR is emptied)
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$1"
rm -rf -- "$work"
mkdir -p -- "$work"
work="$(cd "$work" && pwd)"
fail() { printf 'solver_only: %s\n' "$*" >&2; exit 1; }

configure() {  # NAME SOURCE [OPTION...]
  local name="$1" from="$2"
  shift 2
  cmake -S "$from" -B "$work/$name" -G Ninja -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF "$@" >"$work/$name.log" 2>&1
}
said() { grep -q "$2" <<<"$(tr -s '\n ' ' ' <"$work/$1.log")"; }  # CMake breaks lines
has() { grep -q "^$1:" <<<"$targets"; }
without=(-DGRAPHSOLVE_BUILD_PHYSICS=OFF)
for package in fmt tomlplusplus CLI11; do without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done

configure part "$source_dir/tests/consumer/add_subdirectory" -DREPOSITORY="$source_dir" "${without[@]}" ||
  { cat "$work/part.log" >&2; fail "as a part of another project it is not configured"; }
said part "graphsolve::physics is left out (GRAPHSOLVE_BUILD_PHYSICS=OFF), and with it the program" ||
  fail "nothing is said of what is left out"
targets="$(cmake --build "$work/part" --target help)"
has graphsolve || fail "the solver is left out"
for target in physics graphsolve_cli; do ! has $target || fail "$target is not left out"; done

configure whole "$source_dir" "${without[@]}" || { cat "$work/whole.log" >&2; fail "by itself it is not configured"; }
targets="$(cmake --build "$work/whole" --target help)"
for target in graphsolve_tests threads_tests solver_minimal; do
  has $target || fail "$target is left out"
done
for target in physics physics_tests graphsolve_cli cli_tests simulator_minimal throw_to_target campaign bench_step; do
  ! has $target || fail "$target is not left out"
done

# What is installed, with an empty library in the place of the one that would have been compiled.
: >"$work/whole/graphsolve/libgraphsolve.a"
cmake --install "$work/whole" --prefix "$work/prefix" --component development >"$work/install.log"
[[ -z "$(find "$work/prefix" -iname '*physics*')" ]] || fail "files of the simulator are installed"
user() {  # NAME COMPONENTS
  configure "$1" "$source_dir/tests/consumer/find_package" -DCMAKE_PREFIX_PATH="$work/prefix" \
    -DEXAMPLES="$source_dir/examples" "-DPARTS=$2"
}
user solver graphsolve || { cat "$work/solver.log" >&2; fail "the solver is not found"; }
! user simulator "graphsolve;physics" || fail "the simulator was found"
said simulator "graphsolve::physics is missing: this installation was built with GRAPHSOLVE_BUILD_PHYSICS=OFF" ||
  { cat "$work/simulator.log" >&2; fail "no reason was given"; }
printf 'solver_only: configured without the simulator, fmt, toml++ and CLI11\n'
