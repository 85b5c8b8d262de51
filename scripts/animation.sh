#!/usr/bin/env bash
# The animation of the README, from the sample survey of gpr20_analysis.
#   scripts/animation.sh           into docs/images
#   scripts/animation.sh FILE      into another file: .webp, .gif or .png
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
exec "$GPR20_VENV/bin/python" "$GPR20_ROOT/scripts/pictures/animation.py" \
    "${1:-$GPR20_ROOT/docs/images/survey.webp}"
