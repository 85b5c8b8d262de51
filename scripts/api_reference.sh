#!/usr/bin/env bash
# The reference of the public interface of gpr20_analysis as HTML, made from its docstrings by pdoc.
#   scripts/api_reference.sh OUTPUT_DIR
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh" --dev
exec "$GPR20_VENV/bin/python" "$GPR20_ROOT/tools/pages/api_reference.py" \
    "${1:?name a folder for the pages}"
