#!/usr/bin/env bash
# Install what is missing: Debian packages, the virtual environment, the catkin build.
# Safe to run again; quick when nothing is missing.
#   scripts/setup.sh           what a survey needs
#   scripts/setup.sh --dev     what the tests need as well
#   scripts/setup.sh --robot   on the Raspberry Pi: what its pins and its SPI bus need as well;
#                              without the analysis
#   scripts/setup.sh --analysis   the analysis with --robot too, for a robot that keeps its data
#   scripts/setup.sh --scikit-rf   what another VNA needs as well (docs/another_analyzer.md)
#   scripts/setup.sh --check   install nothing; end with status 1 if something is missing
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

DEBIAN_PACKAGES=(
    catkin cmake g++ make python3-dev python3-venv
    ros-base ros-base-dev python3-actionlib python3-diagnostic-msgs python3-diagnostic-updater
    python3-numpy python3-pyqt5 python3-rosbag python3-rospy python3-rostest python3-sensor-msgs
    python3-rosmsg python3-rosnode python3-rosservice python3-rostopic python3-std-srvs
    python3-visualization-msgs rosbash x11-xserver-utils
)
DEBIAN_DEV_PACKAGES=(
    gettext iproute2 nftables openbox procps python3-psutil xdotool xvfb
)

dev=no robot=no analysis=no scikit_rf=no check=no
for argument in "$@"; do
    case "$argument" in
        --dev) dev=yes ;;
        --robot) robot=yes ;;
        --analysis) analysis=yes ;;
        --scikit-rf) scikit_rf=yes ;;
        --check) check=yes ;;
        *)
            echo "setup.sh: unknown argument '$argument';" \
                "allowed: --dev, --robot, --analysis, --scikit-rf and --check" >&2
            exit 2
            ;;
    esac
done
[ "$dev" = no ] || DEBIAN_PACKAGES+=("${DEBIAN_DEV_PACKAGES[@]}")

case "$GPR20_ROOT" in
    *[[:space:]]*)
        echo "setup.sh: the path '$GPR20_ROOT' has a space, which catkin cannot build in;" \
            "move the checkout" >&2
        exit 1
        ;;
esac

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# With --check, say what would be done and end.
refuse_if_checking() {
    [ "$check" = yes ] || return 0
    echo "the environment is not set up ($1); run scripts/setup.sh first" >&2
    exit 1
}

install_debian_packages() {
    local missing=() package
    for package in "${DEBIAN_PACKAGES[@]}"; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null |
            grep -q 'ok installed' || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0
    refuse_if_checking "missing Debian packages: ${missing[*]}"
    echo "installing Debian packages: ${missing[*]}"
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# What is imported (requirements/*.in), in the versions that are pinned for this Python.
install_python_packages() {
    local lists=(nodes.in) arguments=() inputs=() version pins list
    [ "$dev" = no ] || lists+=(test.in lint.in scikit_rf.in)
    [ "$scikit_rf" = no ] || lists+=(scikit_rf.in)
    [ "$robot" = no ] || lists+=(robot.in)
    version="$(/usr/bin/python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
    pins="$GPR20_ROOT/requirements/python$version.txt"
    if [ ! -f "$pins" ]; then
        echo "setup.sh: $pins is missing; add Python $version to scripts/requirements.sh" >&2
        exit 1
    fi
    # Its programs name its folder, so it is made again after the checkout was moved.
    if [ ! -x "$GPR20_VENV/bin/python" ] ||
        ! grep -qsE "VIRTUAL_ENV=[\"']?$GPR20_VENV[\"']?\$" "$GPR20_VENV/bin/activate"; then
        refuse_if_checking "missing: $GPR20_VENV"
        rm -rf "$GPR20_VENV"
        echo "making the virtual environment $GPR20_VENV"
        /usr/bin/python3 -m venv --system-site-packages "$GPR20_VENV"
    fi
    for list in "${lists[@]}"; do
        list="$GPR20_ROOT/requirements/$list"
        is_installed "$list" || { arguments+=(-r "$list"); inputs+=("$list"); }
    done
    # Most surveys are analysed elsewhere than on the robot. gpr20 runs from its sources.
    list="$GPR20_WORKSPACE/src/gpr20_analysis/pyproject.toml"
    if { [ "$robot" = no ] || [ "$analysis" = yes ]; } && ! is_installed "$list"; then
        arguments+=(--editable "$(dirname "$list")[all]")
        inputs+=("$list")
    fi
    [ ${#arguments[@]} -gt 0 ] || return 0
    refuse_if_checking "missing Python packages of: ${inputs[*]##*/}"
    echo "installing the Python packages of: ${inputs[*]##*/}"
    "$GPR20_VENV/bin/python" -m pip install --quiet --disable-pip-version-check \
        --constraint "$pins" "${arguments[@]}"
    for list in "${inputs[@]}"; do cat "$list" "$pins" >"$(stamp_of "$list")"; done
}

# What was installed last because of a list.
stamp_of() {
    echo "$GPR20_VENV/installed-$(basename "$1")"
}

is_installed() {
    cat "$1" "$pins" | cmp -s - "$(stamp_of "$1")"
}

# Python sources run from where they are; only these files decide what the build makes.
build_inputs() {
    (cd "$GPR20_ROOT" && find -L catkin_ws/src -mindepth 2 \
        \( -name package.xml -o -name CMakeLists.txt -o -name setup.py -o -name CATKIN_IGNORE \
        -o -name '*.msg' -o -name '*.srv' -o -name '*.action' \
        -o -path '*/nodes/*' -o -path '*/env-hooks/*' \) \
        -type f -not -path '*/__pycache__/*' -print0 | sort -z | xargs -0 sha256sum
        echo "$GPR20_ROOT")
}

build_workspace() {
    local stamp="$GPR20_WORKSPACE/build/inputs.sha256" inputs log
    inputs="$(build_inputs)"
    if [ -f "$stamp" ] && [ "$inputs" = "$(cat "$stamp")" ]; then return 0; fi
    refuse_if_checking "the catkin workspace is not built from these sources"
    echo "building the catkin workspace"
    # The build names its folder too.
    grep -qsxF "CMAKE_HOME_DIRECTORY:INTERNAL=$GPR20_WORKSPACE/src" \
        "$GPR20_WORKSPACE/build/CMakeCache.txt" ||
        rm -rf "$GPR20_WORKSPACE/build" "$GPR20_WORKSPACE/devel"
    log="$(mktemp)"
    if ! catkin_make -C "$GPR20_WORKSPACE" -DPYTHON_EXECUTABLE="$GPR20_VENV/bin/python3" \
        -DCATKIN_ENABLE_TESTING=OFF >"$log" 2>&1; then
        cat "$log" >&2
        echo "setup.sh: the catkin build failed; the lines above say where" >&2
        exit 1
    fi
    rm -f "$log"
    printf '%s\n' "$inputs" >"$stamp"
}

install_debian_packages
install_python_packages
build_workspace
