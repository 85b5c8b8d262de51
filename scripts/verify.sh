#!/usr/bin/env bash
# Check a survey's folder: manifest, files, numbers, coverage. Needs Python and the packages of
# gpr20_analysis/pyproject.toml, no ROS.
#   scripts/verify.sh FOLDER
# Exit status: 0 complete and intact, 1 not complete or not sealed, 2 damaged or contradictory,
# 3 no survey.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
python="$GPR20_VENV/bin/python"
[ -x "$python" ] || python=python3
PYTHONPATH="$(printf '%s:' "$GPR20_ROOT"/catkin_ws/src/*/src)${PYTHONPATH:-}" \
    exec "$python" -m gpr20_analysis.commands.main verify "$@"
