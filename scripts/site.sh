#!/usr/bin/env bash
# The documentation as one site; open its index.html. A link that leads nowhere is an error.
#   scripts/site.sh           into site/
#   scripts/site.sh FOLDER    into another folder, which is replaced
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh" --dev
folder="$(realpath -m "${1:-$GPR20_ROOT/site}")"
# MkDocs recommends other programs in a notice of its theme.
packages="$(printf ':%s' "$GPR20_WORKSPACE"/src/*/src)"
export NO_MKDOCS_2_WARNING=1 PYTHONPATH="$GPR20_ROOT/tools/site$packages"
"$GPR20_VENV/bin/python" -m mkdocs build --strict \
    --config-file "$GPR20_ROOT/mkdocs.yml" --site-dir "$folder"
echo "The site is $folder/index.html"
