#!/usr/bin/env bash
# Style and types: ruff everywhere, mypy below the high levels, who may import whom, catkin_lint, shell syntax.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"
gpr20_use_workspace

nodes=(catkin_ws/src/*/nodes/*)
ruff check . "${nodes[@]}"
ruff format --check . "${nodes[@]}"

# Not the high levels: ROS has no types.
shopt -s nullglob
levels=(catkin_ws/src/*/src/*/{mid,low,views,read,formats,processing,imaging,plotting,report,commands} catkin_ws/src/*/src/gpr20_survey)
MYPYPATH="$(printf '%s:' catkin_ws/src/*/src)" mypy --no-error-summary "${levels[@]}"

PYTHONPATH="$(printf '%s:' catkin_ws/src/*/src)$PYTHONPATH" lint-imports --no-cache --no-logo
catkin_lint --quiet -W1 --ignore unknown_package catkin_ws/src
for script in scripts/*.sh .ci/run; do bash -n "$script"; done
echo "lint: nothing to complain about"
