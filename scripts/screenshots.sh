#!/usr/bin/env bash
# Pictures of the windows in both languages, that of the robot in 800x480, from surveys of the
# simulated robot.
#   scripts/screenshots.sh                   every tab, over two targets, into docs/images
#   scripts/screenshots.sh FOLDER            the same into another folder
#   scripts/screenshots.sh --sizes FOLDER    every tab and sheet in 3 sizes, 2 languages, 2 themes
#   scripts/screenshots.sh --faults FOLDER   STATUS, after each fault of the simulator
#   scripts/screenshots.sh --replay SURVEY   a replay of a recorded survey, into docs/images
#   scripts/screenshots.sh --candidates SURVEY   the candidates of a survey, into docs/images
#   scripts/screenshots.sh --view SURVEY     gpr20 view of a survey, 1360x820, into docs/images
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh" --dev
gpr20_use_workspace
export ROS_IP=127.0.0.1
export PYTHONPATH="$GPR20_ROOT/benchmarks:$PYTHONPATH"
if [ "${1:-}" = --sizes ]; then
    exec python "$GPR20_ROOT/scripts/size_screenshots.py" "${2:?name a folder for the pictures}"
fi
if [ "${1:-}" = --faults ]; then
    exec python "$GPR20_ROOT/scripts/fault_screenshots.py" "${2:?name a folder for the pictures}"
fi
if [ "${1:-}" = --replay ]; then
    exec python "$GPR20_ROOT/scripts/replay_screenshots.py" "${2:?name a survey}" \
        "${3:-$GPR20_ROOT/docs/images}"
fi
if [ "${1:-}" = --candidates ]; then
    exec python "$GPR20_ROOT/scripts/candidate_screenshots.py" "${2:?name a survey}" \
        "${3:-$GPR20_ROOT/docs/images}"
fi
if [ "${1:-}" = --view ]; then
    exec python "$GPR20_ROOT/scripts/view_screenshots.py" "${2:?name a survey}" \
        "${3:-$GPR20_ROOT/docs/images}"
fi
exec python "$GPR20_ROOT/scripts/screenshots.py" "${1:-$GPR20_ROOT/docs/images}"
