#!/usr/bin/env bash
# Builds the program and runs the main job: simulates the paper's hopper and quadruped, then measures how the cost
# grows with contacts and bodies (Figs. 4 and 5) and how the error falls with the time spent.
# Usage: scripts/demo.sh [DIR]      results go to DIR (default demo-out, in the current directory)
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

if [[ ${1:-} == -h || ${1:-} == --help ]]; then sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; fi
if (($# > 1)) || [[ ${1:-} == -* ]]; then
  printf 'demo.sh: takes one folder, not: %s (see demo.sh --help)\n' "$*" >&2
  exit 2
fi
out="${1:-demo-out}"
mkdir -p -- "$out"
out="$(cd -- "$out" && pwd)"

"$root/scripts/setup"
(
  cd "$root"
  cmake --preset release
  cmake --build --preset release --parallel "$(nproc)" --target graphsolve_cli
)
program="$root/build/release/bin/graphsolve"

# Runs the program; a failed step (code 1) or wrong input (code 2) ends the demo with a sentence.
run() {
  printf '\n$ graphsolve %s\n' "$*"
  local code=0
  "$program" "$@" || code=$?
  case $code in
    0) ;;
    1) printf 'demo.sh: a step failed; the trajectory so far is in %s\n' "$out" >&2; exit 1 ;;
    *) printf 'demo.sh: graphsolve ended with code %s\n' "$code" >&2; exit "$code" ;;
  esac
}

for scene in hopper quadruped; do
  run simulate "$scene" --out "$out/$scene.json" --summary "$out/$scene-summary.json"
done
run study scaling precision --quick --out "$out"

printf '\nResults in %s:\n' "$out"
(cd -- "$out" && find . -maxdepth 2 -type f -size +0 | sort | sed 's|^\./|  |')
printf 'Trajectories (.json) can be simulated again: graphsolve simulate FILE. Pictures are the .svg files.\n'
