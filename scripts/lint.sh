#!/usr/bin/env bash
# Style, types, who may import whom, translations, package files, shell.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"
gpr20_use_workspace

nodes=(catkin_ws/src/*/nodes/*)
ruff check . "${nodes[@]}"
ruff format --check . "${nodes[@]}"

# The messages are those that the build made.
messages=catkin_ws/devel/lib/python3/dist-packages
packages=(catkin_ws/src/*/src deploy/update)
MYPYPATH="$(printf '%s:' "${packages[@]}" tools tools/{checks,kits} benchmarks)$messages"
export MYPYPATH
types=(mypy --no-error-summary --scripts-are-modules)
"${types[@]}" "${packages[@]}" catkin_ws/src/*/nodes/* conftest.py deploy/*.py \
    tools/*.py tools/{checks,kits,site}/*.py tools/fault_suite
# Apart, because a benchmark may have the name of a node.
"${types[@]}" benchmarks/*.py

PYTHONPATH="$(printf '%s:' "${packages[@]}")$PYTHONPATH" lint-imports --no-cache --no-logo
scripts/translations.sh --check
catkin_lint --quiet -W1 --ignore unknown_package catkin_ws/src
# What is sourced names its shell for shellcheck.
mapfile -t shells < <(git grep -lE '^#( shellcheck shell=|!(/bin/sh|/usr/bin/env bash))' -- \
    deploy debian scripts .ci)
if grep -nE '^.{101}' "${shells[@]}" >&2; then
    echo "lint.sh: break these lines after at most 100 characters" >&2
    exit 1
fi
for script in "${shells[@]}"; do bash -n "$script"; done
echo "lint: nothing to complain about"
