#!/usr/bin/env bash
# The catalogues of the sentences that operators read (tools/checks/translations.py).
#   scripts/translations.sh                     update each: new sentences have an empty msgstr
#   scripts/translations.sh --check             fail on a sentence without Spanish, and on an entry
#                                               that no program has or with other {values}
#   scripts/translations.sh FILE.po             update a catalogue of another folder
#   scripts/translations.sh --check FILE.po     check it; entries may be missing
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
PYTHONPATH="$(printf '%s:' "$GPR20_WORKSPACE"/src/gpr20_*/src)" exec "$GPR20_VENV/bin/python" \
    "$GPR20_ROOT/tools/checks/translations.py" "$@"
