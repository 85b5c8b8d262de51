#!/usr/bin/env bash
# Install what is missing, then run the tests: one run of pytest, side by side.
#   scripts/test.sh                  what every change has to pass
#   scripts/test.sh PART|PATH ...    only these: lint, unit, ros, commands, or test files
#   scripts/test.sh release          the rest, and random tests at length; so does release.sh
#   scripts/test.sh random [PART]    random tests draw other inputs than in each run before;
#                                    GPR20_SEED=N repeats those of a run
# The end says what failed, what was skipped and why, and what was left running.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

paths=() options=() versions=()
for argument in "$@"; do
    case "$argument" in
        lint) paths+=("$GPR20_ROOT/scripts/test/test_source_rules.py") ;;
        unit) paths+=("$GPR20_ROOT"/catkin_ws/src/*/test/unit) options+=(--cov --cov-report=) ;;
        ros) paths+=("$GPR20_ROOT"/catkin_ws/src/*/test/ros) ;;
        commands) paths+=("$GPR20_ROOT/scripts/test") ;;
        release)
            options+=(-m "release or hypothesis" --timeout 3600) versions=(3.8 3.13)
            export GPR20_LONG=1 ;;
        random)
            options+=(--timeout 3600)
            export GPR20_LONG=1 GPR20_SEED="${GPR20_SEED:-$RANDOM$RANDOM}" ;;
        *)
            if [ ! -e "${argument%%::*}" ]; then
                echo "test.sh: '$argument' is neither a path nor one of lint, unit, ros," \
                    "commands, release, random" >&2
                exit 2
            fi
            paths+=("$(realpath -s "${argument%%::*}")${argument#"${argument%%::*}"}") ;;
    esac
done
cd "$GPR20_ROOT"
if [ -n "${GPR20_SEED:-}" ]; then
    echo "test.sh: GPR20_SEED=$GPR20_SEED draws the same again"
    options+=("--hypothesis-seed=$GPR20_SEED")
fi

# python_of 3.8: that interpreter, if this machine has it.
python_of() {
    local candidate
    for candidate in "python$1" "$HOME/.pyenv/versions/$1".*/bin/python; do
        # A version manager may have a command of that name that only says which to choose.
        if "$candidate" --version >/dev/null 2>&1; then command -v "$candidate"; return; fi
    done
}

# Make the virtual environment of another Python: .venv38 for 3.8, .venv313 for 3.13.
make_venv() {
    local pins="requirements/python$1.txt" venv="$GPR20_ROOT/.venv${1/./}" python
    python="$(python_of "$1")"
    if [ -z "$python" ]; then echo "no Python $1 here: the tests under it are skipped"; return; fi
    if cmp -s "$pins" "$venv/installed"; then return; fi
    echo "making the virtual environment $venv"
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$pins"
    cp "$pins" "$venv/installed"
}

installations=()
# If the setup fails or is interrupted, nothing keeps running. Each is a process group of its own.
trap 'for group in "${installations[@]}"; do kill -- "-$group" 2>/dev/null || true; done' EXIT
set -m
for version in "${versions[@]}"; do
    make_venv "$version" & installations+=($!)
done
set +m
scripts/setup.sh --dev
for installation in "${installations[@]}"; do wait "$installation"; done
# Many tests wait for the robot more than they compute.
# A file's tests share its fixtures. The workers get the files in the order of the tests.
exec "$GPR20_VENV/bin/python" -m pytest --numprocesses $(($(nproc) + 2)) --dist loadfile \
    --no-loadscope-reorder --max-worker-restart 0 --durations 20 "${options[@]}" "${paths[@]}"
