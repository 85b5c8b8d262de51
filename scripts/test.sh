#!/usr/bin/env bash
# Install what is missing, then run every check of the project:
# lint, the unit tests (under Python 3.8 too where it is present), the rostests, the commands of the README.
#   scripts/test.sh            everything
#   scripts/test.sh lint|unit|unit38|ros|commands ...   only these parts
# The robot's time limits are real seconds, which a machine that stalls breaks without anybody's fault: tests that
# failed are tried once more, and both outcomes are shown.
set -uo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT" || exit 1
"$GPR20_ROOT/scripts/setup.sh" --dev || exit 1
gpr20_use_workspace

parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(lint unit unit38 ros commands)
results="$(mktemp -d)"
passed=0 failed=0 second_tries=0

# Begin a check in the background; `finish` tells how it ended.
begin() {
    local name="$1" log
    log="$(log_of "$name")"
    shift
    (
        begun=$SECONDS
        status=0
        export PYTEST_ADDOPTS="-o cache_dir=$log.cache"
        "$@" >"$log" 2>&1 || status=$?
        if [ "$status" -ne 0 ] && [ "$1" != scripts/lint.sh ]; then
            status=0
            mv "$log" "$log.first"
            PYTEST_ADDOPTS+=" --last-failed"
            "$@" >"$log" 2>&1 || status=$?
        fi
        echo "$status $((SECONDS - begun))" >"$log.end"
    ) &
}

# Wait for a check, show its output if it failed, and count it.
finish() {
    local name="$1" log status seconds
    log="$(log_of "$name")"
    printf '%-58s' "$name"
    wait
    read -r status seconds <"$log.end"
    if [ "$status" -eq 0 ] && [ ! -f "$log.first" ]; then
        echo "passed   $seconds s  $(summary_of "$log")"
        passed=$((passed + 1))
    elif [ "$status" -eq 0 ]; then
        echo "passed at the second try   $seconds s  $(summary_of "$log")"
        echo "--- the first try:"
        cat "$log.first"
        passed=$((passed + 1))
        second_tries=$((second_tries + 1))
    else
        echo "FAILED   $seconds s"
        cat "$log"
        failed=$((failed + 1))
    fi
}

check() {
    begin "$@"
    finish "$1"
}

log_of() {
    echo "$results/${1//[\/ ]/_}.log"
}

# How many tests a log of pytest or rostest speaks of.
summary_of() {
    grep -ahoE '[0-9]+ passed.*in|\* TESTS: [0-9]+' "$1" | tail -n 1 | sed -E 's/ in$//; s/\* TESTS: ([0-9]+)/\1 passed/'
}

unit_tests() {
    PYTHONPATH="$(printf '%s:' "$GPR20_ROOT"/catkin_ws/src/*/src)" "$@" -m pytest -q catkin_ws/src/*/test/unit
}

# The interpreter of ROS Noetic, if this machine has one.
python38() {
    local candidate
    for candidate in python3.8 "$HOME"/.pyenv/versions/3.8.*/bin/python; do
        # A version manager may have a command of that name that only says which to choose.
        if "$candidate" --version >/dev/null 2>&1; then command -v "$candidate"; return; fi
    done
}

unit_tests_38() {
    local venv="$GPR20_ROOT/.venv38"
    if ! cat requirements*.txt | cmp -s - "$venv/installed-requirements"; then
        rm -rf "$venv"
        "$1" -m venv "$venv" &&
            "$venv/bin/pip" install --quiet --disable-pip-version-check -r requirements-unit.txt &&
            cat requirements*.txt >"$venv/installed-requirements" || return 1
    fi
    # ROS's own packages belong to the other interpreter.
    (unset PYTHONPATH; unit_tests "$venv/bin/python")
}

ros_test() {
    ROS_IP=127.0.0.1 ROS_TEST_RESULTS_DIR="$results" rostest "$1" "$2"
}

# The unit tests under each interpreter, side by side: one core each.
unit_checks() {
    local part name names=()
    for part in "$@"; do
        if [ "$part" = unit ]; then
            name="unit tests, $(python --version)"
            begin "$name" unit_tests python
        elif [ -n "$(python38)" ]; then
            name="unit tests, $("$(python38)" --version)"
            begin "$name" unit_tests_38 "$(python38)"
        else
            echo "no Python 3.8 here: the unit tests run under $(python --version) alone"
            continue
        fi
        names+=("$name")
    done
    for name in "${names[@]}"; do finish "$name"; done
}

case " ${parts[*]} " in
    *" unit unit38 "*) parts=("${parts[@]/#unit38/}") both=(unit unit38) ;;
    *) both=() ;;
esac
for part in "${parts[@]}"; do
    case "$part" in
        '') ;;
        lint) check lint scripts/lint.sh ;;
        unit) unit_checks "${both[@]:-unit}" ;;
        unit38) unit_checks unit38 ;;
        ros)
            for file in catkin_ws/src/*/test/ros/*.test; do
                package="$(basename "$(dirname "$(dirname "$(dirname "$file")")")")"
                check "$package/$(basename "$file")" ros_test "$package" "$(basename "$file")"
            done
            ;;
        commands) check "commands of the README" python -m pytest -q scripts/test ;;
        *) echo "test.sh: unknown part '$part'; allowed are lint, unit, unit38, ros, commands" >&2; exit 2 ;;
    esac
done

echo
echo "$passed passed, $second_tries of them at the second try, $failed failed"
[ "$failed" -eq 0 ]
