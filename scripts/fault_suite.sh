#!/usr/bin/env bash
# Make accidents of the storage on purpose (kills, power cuts, failing disks, two writers), and look
# for all that it had acknowledged. Prints a line for each kind.
#   scripts/fault_suite.sh                           everything, for a release
#   scripts/fault_suite.sh --count 3                 a few of each kind, in seconds
#   scripts/fault_suite.sh --data DIR --only cuts    some kinds on the disk of this folder
#   scripts/fault_suite.sh --help                    what else can be chosen, and the exit status
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
if [ ! -x "$GPR20_VENV/bin/python" ]; then
    echo "fault_suite.sh: run scripts/setup.sh first" >&2
    exit 2
fi
sources="$(printf '%s:' "$GPR20_ROOT"/catkin_ws/src/*/src)"
PYTHONPATH="$GPR20_TOOLS:${PYTHONPATH:+$PYTHONPATH:}${sources%:}" \
    exec "$GPR20_VENV/bin/python" -m fault_suite "$@"
