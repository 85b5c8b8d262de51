#!/usr/bin/env bash
# Kill the storage, cut its power, let its disk fail and flip bits on purpose, and look for every
# acknowledged trace, marker, annotation and report. Prints one table.
#   scripts/fault_suite.sh --data DIR    on the disk of this folder, about 2 minutes
#   scripts/fault_suite.sh --help        what else can be chosen, and the exit status
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
python="$GPR20_VENV/bin/python"
if [ ! -x "$python" ]; then
    echo "fault_suite.sh: run scripts/setup.sh first" >&2
    exit 2
fi
PYTHONPATH="$GPR20_TOOLS:$(printf '%s:' "$GPR20_ROOT"/catkin_ws/src/*/src)${PYTHONPATH:-}" \
    exec "$python" -m fault_suite "$@"
