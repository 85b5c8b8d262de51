#!/usr/bin/env bash
# The pictures of docs/architecture.md and docs/ros.md, from their text, into docs/images.
#   scripts/pictures.sh
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
exec "$GPR20_VENV/bin/python" "$GPR20_ROOT/scripts/pictures/architecture_pictures.py"
