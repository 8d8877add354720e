#!/usr/bin/env bash
# Installs a build tree, moves what was installed, and builds two tiny programs against it: by find_package and by pkg-config.
# Usage: tests/consumer/installed.sh BUILD_DIR WORK_DIR     (WORK_DIR is emptied)
set -euo pipefail
source_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$(cd "$1" && pwd)"
work="$2"
rm -rf -- "$work"
mkdir -p -- "$work"
work="$(cd "$work" && pwd)"

for component in runtime development; do  # not the program: it need not have been built
  cmake --install "$build" --prefix "$work/first" --component $component >"$work/install-$component.log"
done
mv "$work/first" "$work/moved"
"$source_dir/tests/consumer/use.sh" "$work/moved" "$work"
