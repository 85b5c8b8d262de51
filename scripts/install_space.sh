#!/usr/bin/env bash
# Make an install space: a folder from which the robot runs without this checkout. It can be copied
# to another folder or to a machine with the same distribution (docs/install_space.md).
#   scripts/install_space.sh FOLDER              the workspace, and in FOLDER/venv the Python
#                                                packages that the system does not have
#   scripts/install_space.sh FOLDER --robot      for the Raspberry Pi: what its pins and its SPI
#                                                bus need as well; without the analysis
#   scripts/install_space.sh FOLDER --analysis   the analysis with --robot too
#   scripts/install_space.sh FOLDER --no-venv    the workspace alone
# Needs the Debian packages that scripts/setup.sh installs. A FOLDER that exists is updated.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
PYTHON=/usr/bin/python3
# Sourced if it is there; Debian's packages of ROS need no setup file.
ROS_SETUP="${GPR20_ROS_PREFIX:-/opt/ros/noetic}/setup.bash"

folder='' robot=no analysis=no venv=yes
for argument in "$@"; do
    case "$argument" in
        --robot) robot=yes ;;
        --analysis) analysis=yes ;;
        --no-venv) venv=no ;;
        -*) folder='' && break ;;
        *) folder="$(realpath -ms "$argument")" ;;
    esac
done
if [ -z "$folder" ]; then
    echo "install_space.sh: name a folder; allowed options: --robot, --analysis, --no-venv" >&2
    exit 2
fi

# run_clean COMMAND...: with the system's ROS alone; what this shell sourced or activated does not
# become a part of the install space.
run_clean() {
    env -u CMAKE_PREFIX_PATH -u PYTHONPATH -u VIRTUAL_ENV PATH=/usr/local/bin:/usr/bin:/bin \
        bash -c '[ ! -f "$0" ] || source "$0"; exec "$@"' "$ROS_SETUP" "$@"
}

if ! run_clean bash -c "command -v catkin_make" >/dev/null; then
    echo "install_space.sh: catkin_make is missing; run scripts/setup.sh first" >&2
    exit 1
fi

build="$(mktemp -d)"
trap 'rm -rf "$build"' EXIT

# run_quietly WHAT COMMAND...: run it clean; what it prints is shown only if it fails.
run_quietly() {
    if ! run_clean "${@:2}" >"$build/log" 2>&1; then
        cat "$build/log" >&2
        echo "install_space.sh: $1 failed; the lines above say where" >&2
        exit 1
    fi
}

install_workspace() {
    echo "building and installing the workspace in $folder (typically 30 s)"
    run_quietly "the catkin build" \
        catkin_make -C "$GPR20_WORKSPACE" --build "$build/build" install \
        -DCATKIN_DEVEL_PREFIX="$build/devel" -DCMAKE_INSTALL_PREFIX="$folder" \
        -DPYTHON_EXECUTABLE="$PYTHON" -DCATKIN_ENABLE_TESTING=OFF
    # Its user may not write there. By content, because a copy may have other times.
    "$PYTHON" -m compileall -q --invalidation-mode checked-hash "$folder/lib/python3"
}

install_python_packages() {
    local version pins pip wing arguments=(-r "$GPR20_ROOT/requirements/nodes.in")
    version="$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
    pins="$GPR20_ROOT/requirements/python$version.txt"
    if [ ! -f "$pins" ]; then
        echo "install_space.sh: $pins is missing;" \
            "add Python $version to scripts/requirements.sh" >&2
        exit 1
    fi
    [ "$robot" = no ] || arguments+=(-r "$GPR20_ROOT/requirements/robot.in")
    if [ "$robot" = no ] || [ "$analysis" = yes ]; then
        arguments+=("$GPR20_WORKSPACE/src/gpr20_analysis[all]")
        # The workspace also works without the folders of these.
        for wing in "$GPR20_WORKSPACE"/src/gpr20_{foreign_formats,viewer}; do
            [ ! -d "$wing" ] || arguments+=("$wing")
        done
    fi
    echo "installing the Python packages in $folder/venv (typically 1 min)"
    "$PYTHON" -m venv --system-site-packages "$folder/venv"
    pip=("$folder/venv/bin/python3" -m pip --quiet --disable-pip-version-check)
    # That of Ubuntu 20.04 does not know the wheels of today.
    case "$(run_clean "${pip[@]}" --version)" in
        "pip 20."* | "pip 21."*)
            run_quietly "the update of pip" "${pip[@]}" install --upgrade pip ;;
    esac
    run_quietly "the installation of Python packages" \
        "${pip[@]}" install --constraint "$pins" "${arguments[@]}"
    # Only what they need: they themselves are in the workspace.
    if run_clean "${pip[@]}" show gpr20_analysis >/dev/null 2>&1; then
        run_quietly "pip" \
            "${pip[@]}" uninstall --yes gpr20_analysis gpr20_foreign_formats gpr20_viewer
    fi
}

install_workspace
[ "$venv" = no ] || install_python_packages
cat <<END
The install space is $folder ($(du -sh "$folder" | cut -f1)). Use it, or a copy of it:
  source $folder/setup.bash
  roslaunch gpr20 survey.launch
END
