#!/usr/bin/env bash
# Install what is missing, then run every check of the project:
# lint, the unit tests (under Python 3.8 too where it is present), the rostests, the commands of the README.
#   scripts/test.sh            everything
#   scripts/test.sh lint|unit|unit38|ros|commands ...   only these parts
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"

# A Python of this version that runs, if this machine has one.
other_python() {
    local candidate
    for candidate in "python$1" "$HOME/.pyenv/versions/$1".*/bin/python; do
        # A version manager may have a command of that name that only says which to choose.
        if "$candidate" --version >/dev/null 2>&1; then command -v "$candidate"; return; fi
    done
}

# Make the virtual environment of another Python: .venv38 for 3.8, .venv313 for 3.13.
install_other_python() {
    local pins="requirements/python$1.txt" venv="$GPR20_ROOT/.venv${1/./}" python
    python="$(other_python "$1")"
    if [ -z "$python" ]; then
        echo "no Python $1 here: its unit tests are skipped"
        return
    fi
    if cmp -s "$pins" "$venv/installed"; then return; fi
    echo "making the virtual environment $venv"
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$pins"
    cp "$pins" "$venv/installed"
}

install_other_python 3.8 & python38=$!
install_other_python 3.13 & python313=$!
scripts/setup.sh --dev
wait "$python38"
wait "$python313"
gpr20_use_workspace
exec python scripts/run_checks.py "$@"
