#!/usr/bin/env bash
# Install what is missing, then run every check of the project:
# lint, the unit tests (under Python 3.8 too where it is present), the rostests, the commands of the README.
#   scripts/test.sh            everything
#   scripts/test.sh lint|unit|unit38|ros|commands ...   only these parts
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"

# The interpreter of ROS Noetic, if this machine has one.
python38() {
    local candidate
    for candidate in python3.8 "$HOME"/.pyenv/versions/3.8.*/bin/python; do
        # A version manager may have a command of that name that only says which to choose.
        if "$candidate" --version >/dev/null 2>&1; then command -v "$candidate"; return; fi
    done
}

install_python38_packages() {
    local venv="$GPR20_ROOT/.venv38" python
    python="$(python38)"
    if [ -z "$python" ]; then
        echo "no Python 3.8 here: the unit tests run under Debian's Python alone"
        return
    fi
    cat requirements*.txt | cmp -s - "$venv/installed-requirements" && return
    echo "making the virtual environment $venv"
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r requirements-unit.txt
    cat requirements*.txt >"$venv/installed-requirements"
}

python38_installation=
case " ${*:-unit38} " in
    *" unit38 "*) install_python38_packages & python38_installation=$! ;;
esac
scripts/setup.sh --dev
[ -z "$python38_installation" ] || wait "$python38_installation"
gpr20_use_workspace
exec python scripts/run_checks.py "$@"
