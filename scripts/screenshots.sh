#!/usr/bin/env bash
# Pictures of every tab of the window, 800x480, in both languages, into docs/images: a survey of the simulated robot over two targets.
#   scripts/screenshots.sh [FOLDER]     another folder than docs/images
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh" --dev
gpr20_use_workspace
export ROS_IP=127.0.0.1
PYTHONPATH="$GPR20_ROOT/benchmarks:$PYTHONPATH" exec python "$GPR20_ROOT/scripts/screenshots.py" "${1:-$GPR20_ROOT/docs/images}"
