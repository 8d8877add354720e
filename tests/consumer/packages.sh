#!/usr/bin/env bash
# Builds shared libraries and Debian packages of them, looks into the packages, and builds two tiny programs against what
# is in them. Nothing is installed on this machine.
# Usage: tests/consumer/packages.sh WORK_DIR [--build DIR] [cmake OPTION...]     (WORK_DIR is emptied)
#        --build DIR: turn this build of static libraries into one of shared ones: nothing is compiled again
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$1"
shift
rm -rf -- "$work"
mkdir -p -- "$work"
work="$(cd "$work" && pwd)"
fail() { printf 'packages: %s\n' "$*" >&2; exit 1; }
build="$work/build"
if [[ ${1:-} == --build ]]; then
  build="$(cd "$2" && pwd)"
  shift 2
fi

cmake -S "$source_dir" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
  -DGRAPHSOLVE_BUILD_TESTS=OFF -DGRAPHSOLVE_BUILD_BENCH=OFF -DGRAPHSOLVE_BUILD_BASELINES=OFF \
  -DGRAPHSOLVE_BUILD_EXAMPLES=OFF "$@" >"$work/configure.log"
cmake --build "$build" --parallel "$(nproc)" >"$work/build.log" || { tail -n 40 "$work/build.log" >&2; exit 1; }
(cd "$work" && cpack -G DEB --config "$build/CPackConfig.cmake" >cpack.log 2>&1) || { cat "$work/cpack.log" >&2; exit 1; }

for name in libgraphsolve-dev graphsolve 'libgraphsolve[0-9]*'; do
  # shellcheck disable=SC2206
  found=("$work"/${name}_*.deb)
  [[ -f ${found[0]} ]] || fail "no package $name"
  dpkg-deb --field "${found[0]}" Package Version Depends
  dpkg-deb --extract "${found[0]}" "$work/root"
done
for name in libgraphsolve-dev graphsolve; do
  grep -q 'Apache License' "$work/root/usr/share/doc/$name/copyright" || fail "$name has no licence"
done
dpkg-deb --field "$work"/graphsolve_*.deb Depends | grep -q 'libstdc++6' || fail "the program's libraries were not found"
LD_LIBRARY_PATH="$work/root/usr/lib" "$work/root/usr/bin/graphsolve" scenes >"$work/scenes.txt"
grep -q hopper "$work/scenes.txt" || fail "the packaged program does not run"
"$source_dir/tests/consumer/use.sh" "$work/root/usr" "$work"
