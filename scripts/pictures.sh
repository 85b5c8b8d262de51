#!/usr/bin/env bash
# Make pictures of the documentation: scripts/pictures.sh [--into FOLDER] [NAME ...]
# Without a name: list them, and what each makes. They go into docs/images, or into the folder.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
if [ $# -gt 0 ]; then
    "$GPR20_ROOT/scripts/setup.sh" --dev
fi
gpr20_use_workspace
export ROS_IP=127.0.0.1 PYTHONPATH="$GPR20_TOOLS:${PYTHONPATH:-}"
exec python3 -m pictures "$@"
