#!/usr/bin/env bash
# Style and types: ruff everywhere, mypy on the mid and low levels and the analysis, the direction of imports, catkin_lint, shell syntax.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"
gpr20_use_workspace

nodes=(catkin_ws/src/*/nodes/*)
ruff check . "${nodes[@]}"
ruff format --check . "${nodes[@]}"

levels=(catkin_ws/src/*/src/*/mid catkin_ws/src/*/src/*/low catkin_ws/src/gpr20_analysis/src/gpr20_analysis)
MYPYPATH="$(printf '%s:' catkin_ws/src/*/src)" mypy --no-error-summary "${levels[@]}"

python scripts/check_levels.py catkin_ws/src
catkin_lint --quiet -W1 --ignore unknown_package catkin_ws/src
for script in scripts/*.sh .ci/run; do bash -n "$script"; done
echo "lint: nothing to complain about"
