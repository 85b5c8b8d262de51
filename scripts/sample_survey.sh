#!/usr/bin/env bash
# Record the survey that gpr20_analysis ships as a sample, on the simulated robot, and verify it.
#   scripts/sample_survey.sh           into the sources of gpr20_analysis
#   scripts/sample_survey.sh FILE      into another file, which must end in .mcap
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
gpr20_use_workspace
export ROS_IP=127.0.0.1
PYTHONPATH="$GPR20_TOOLS:$PYTHONPATH" exec python "$GPR20_ROOT/tools/sample_survey.py" \
    "${1:-$GPR20_WORKSPACE/src/gpr20_analysis/src/gpr20_analysis/sample/survey.mcap}"
