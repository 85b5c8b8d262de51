#!/usr/bin/env bash
# Write the pinned requirements of each Python, requirements/python*.txt, from the lists
# requirements/*.in and the dependencies of gpr20_analysis, gpr20_foreign_formats and gpr20_viewer.
# Needs the network.
#   scripts/requirements.sh             pin what a changed list needs, keep the other versions
#   scripts/requirements.sh --upgrade   the newest version of everything
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT/requirements"

sources=../catkin_ws/src
common=(nodes.in test.in scikit_rf.in
    "$sources"/gpr20_{analysis,foreign_formats,viewer}/pyproject.toml
    --extra all --no-emit-package gpr20-analysis)

pin() {
    local python="$1" arguments=("${@:2}")
    "$GPR20_VENV/bin/uv" pip compile --quiet --python-version "$python" "${arguments[@]}" \
        --custom-compile-command scripts/requirements.sh \
        --output-file "python$(cut -d. -f1,2 <<<"$python").txt"
}

# Ubuntu 20.04 with ROS Noetic has Python 3.8.10.
pin 3.8.10 "${common[@]}" system.in "$@"
pin 3.11 "${common[@]}" lint.in docs.in robot.in --constraints debian12.txt "$@"
pin 3.13 "${common[@]}" system.in "$@"
