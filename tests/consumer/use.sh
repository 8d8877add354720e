#!/usr/bin/env bash
# Builds and runs two tiny programs against an installed tree: by find_package and by pkg-config.
# Usage: tests/consumer/use.sh PREFIX WORK_DIR
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
prefix="$1"
work="$2"
examples="$source_dir/examples"
fail() { printf 'consumer: %s\n' "$*" >&2; exit 1; }

libraries="$(dirname "$(find "$prefix" -name 'libgraphsolve.*' -print -quit)")"
export LD_LIBRARY_PATH="$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
check() {  # PROGRAM: prints what its source promises in the first line
  local promised
  promised="$(sed -n '1s/.*Prints: //p' "$examples/${2}_minimal.cpp")"
  [[ "$("$1")" == "$promised" ]] || fail "$1 does not print: $promised"
}

# Nothing of the source or build tree may have got into what is installed.
if grep -rIl -e "$source_dir" "$prefix"; then fail "the files above name the source tree"; fi

configure() {  # FOLDER [OPTION...]
  local folder="$1"
  shift
  cmake -S "$source_dir/tests/consumer/find_package" -B "$work/$folder" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" \
    -DEXAMPLES="$examples" -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF "$@" >"$work/$folder.log" 2>&1
}
configure by_cmake || { cat "$work/by_cmake.log" >&2; exit 1; }
grep -q "^graphsolve_DIR:PATH=$prefix/" "$work/by_cmake/CMakeCache.txt" || fail "another installation was found"
cmake --build "$work/by_cmake" >"$work/build.log" || { cat "$work/build.log" >&2; exit 1; }
check "$work/by_cmake/solver" solver
check "$work/by_cmake/simulator" simulator
# The solver asks for less than the simulator; what cannot be had is refused with a reason.
configure without_eigen -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON -DPARTS=graphsolve ||
  { cat "$work/without_eigen.log" >&2; fail "the solver alone needs Eigen"; }
! configure no_physics -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON || fail "physics was found without Eigen"
tr -s '\n ' ' ' <"$work/no_physics.log" | grep -q "graphsolve::physics needs the package Eigen3, which is not found" ||
  { cat "$work/no_physics.log" >&2; fail "no reason was given"; }
! configure too_new -DWANTED=0.99 || fail "version 0.99 was found"
printf 'find_package: both programs run\n'

command -v pkg-config >/dev/null || { printf 'pkg-config: skipped, the program is not there\n'; exit 0; }
export PKG_CONFIG_PATH="$libraries/pkgconfig"
[[ "$(pkg-config --variable=prefix graphsolve)" -ef "$prefix" ]] || fail "pkg-config does not know where it lies"
mkdir -p "$work/by_pkg_config"
build() {  # NAME PACKAGE
  # shellcheck disable=SC2046
  ${CXX:-c++} -std=c++20 "$examples/${1}_minimal.cpp" -o "$work/by_pkg_config/$1" $(pkg-config --cflags --libs "$2")
  check "$work/by_pkg_config/$1" "$1"
}
build solver graphsolve
build simulator graphsolve-physics
printf 'pkg-config: both programs run\n'
