#!/usr/bin/env bash
# Pictures of the first page of a report of the sample survey and of its map, in both languages.
#   scripts/report_pictures.sh           into docs/images
#   scripts/report_pictures.sh FOLDER    into another folder
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
exec "$GPR20_VENV/bin/python" "$GPR20_ROOT/scripts/report_pictures.py" \
    "${1:-$GPR20_ROOT/docs/images}"
