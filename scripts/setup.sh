#!/usr/bin/env bash
# Install what is missing: Debian packages, the virtual environment, the catkin build.
# Safe to run again; quick when nothing is missing.
#   scripts/setup.sh           what a survey needs
#   scripts/setup.sh --dev     what the tests need as well
#   scripts/setup.sh --robot   on the Raspberry Pi: what its pins and its SPI bus need as well;
#                              without the analysis
#   scripts/setup.sh --analysis   the analysis with --robot too, for a robot that keeps its data
#   scripts/setup.sh --scikit-rf   what another VNA needs as well (gpr20_scikit_rf)
#   scripts/setup.sh --check   install nothing; end with status 1 if something is missing
# It uses the ROS in /opt/ros/noetic if there is one, otherwise Debian's packages. What apt, pip and
# catkin print is in setup.log.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

# shellcheck source=scripts/steps/setup_steps.sh
source "$GPR20_ROOT/scripts/steps/setup_steps.sh"

PYTHON="${GPR20_SYSTEM_PYTHON:-/usr/bin/python3}"
# What they take on the disk [MB], rounded up: docs/evidence/bare_debian.md.
PACKAGES_MB=1600
PYTHON_MB=1000

DEBIAN_PACKAGES=(
    cmake g++ make openssh-client openssl python3-dev python3-venv python3-numpy python3-pyqt5
    python3-pyqt5.qtsvg
)
# Packages of ROS: the name in Debian and, behind the colon, in ROS.
ROS_PACKAGES=(
    catkin:catkin ros-base:ros_base ros-base-dev:message_generation python3-actionlib:actionlib
    python3-diagnostic-msgs:diagnostic_msgs python3-diagnostic-updater:diagnostic_updater
    python3-rosbag:rosbag python3-rospy:rospy python3-rostest:rostest
    python3-sensor-msgs:sensor_msgs python3-rosmsg:rosmsg python3-rosnode:rosnode
    python3-rosservice:rosservice python3-rostopic:rostopic python3-std-srvs:std_srvs
    python3-tf2-msgs:tf2_msgs python3-visualization-msgs:visualization_msgs rosbash:rosbash
)
DEBIAN_DEV_PACKAGES=(
    debhelper git iproute2 logrotate nftables openbox procps python3-psutil xdotool xvfb
)

# The browser in which the tests open the page of gpr20_web: Ubuntu 20.04 has it not in apt.
[ -n "$(ros_setup_file)" ] || DEBIAN_DEV_PACKAGES+=(chromium chromium-driver)

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

# before_change WHAT: with --check, say what is missing and end.
before_change() {
    [ "$check" = yes ] || return 0
    echo "the environment is not set up ($1); run scripts/setup.sh first" >&2
    exit 1
}

# End with a reason if nothing can be installed or built here.
check_place() {
    local folder
    case "$GPR20_ROOT" in
        *[[:space:]]*)
            fail "the path '$GPR20_ROOT' has a space, which catkin cannot build in;" \
                "move the checkout" ;;
    esac
    [ -e /proc/self ] || fail "/proc is not mounted; run as root: mount -t proc proc /proc"
    { [ -d /dev/shm ] && [ -w /dev/shm ]; } ||
        fail "/dev/shm, memory that the nodes share, is not there or not writable; run as root:" \
            "mkdir -p /dev/shm && mount -t tmpfs -o mode=1777 tmpfs /dev/shm"
    getent hosts localhost >/dev/null ||
        fail "localhost has no address here, which ROS needs; run as root:" \
            "echo 127.0.0.1 localhost >>/etc/hosts"
    [ "$check" = no ] || return 0
    for folder in "$GPR20_ROOT" "$GPR20_WORKSPACE" "$GPR20_WORKSPACE/src" "$GPR20_VENV" \
        "$GPR20_WORKSPACE/build" "$GPR20_WORKSPACE/devel"; do
        if [ -e "$folder" ] && [ ! -w "$folder" ]; then
            fail "$(id -un) cannot write to $folder, which belongs to $(stat -c %U "$folder");" \
                "run this as that user, or use a copy of your own"
        fi
    done
}

# need_disk FOLDER MB WHAT: end if the disk of a folder has less free.
need_disk() {
    local free_mb
    free_mb="$(df -Pm "$1" | awk 'NR == 2 { print $4 }')"
    [ "$free_mb" -ge "$2" ] ||
        fail "the disk of $1 has $free_mb MB free; $3 need about $2 MB: free some space"
}

install_debian_packages() {
    local missing
    mapfile -t missing < <(missing_packages "${DEBIAN_PACKAGES[@]}" -- "${ROS_PACKAGES[@]}")
    [ ${#missing[@]} -gt 0 ] || return 0
    before_change "missing Debian packages: ${missing[*]}"
    install_packages "${missing[@]}"
}

# What is imported (requirements/*.in), in the versions that are pinned for this Python.
install_python_packages() {
    local lists=(nodes.in) arguments=() inputs=() names=() gone='' version list source
    local venv_is_new=no
    [ "$dev" = no ] || lists+=(test.in lint.in docs.in scikit_rf.in)
    [ "$scikit_rf" = no ] || lists+=(scikit_rf.in)
    [ "$robot" = no ] || lists+=(robot.in)
    [ -x "$PYTHON" ] || before_change "missing: $PYTHON"
    version="$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
    pins="$GPR20_ROOT/requirements/python$version.txt"
    [ -f "$pins" ] || fail "$pins is missing; add Python $version to scripts/requirements.sh"
    [ -e "$GPR20_VENV/installed" ] && gone="$(in_environment |
        LC_ALL=C comm -13 - "$GPR20_VENV/installed" | tr '\n' ' ')"
    # Its programs name its folder, so it is made again after the checkout was moved; and after a
    # part of a package was removed, which pip does not see.
    if [ ! -x "$GPR20_VENV/bin/python" ] || [ -n "$gone" ] ||
        ! grep -qsE "VIRTUAL_ENV=[\"']?$GPR20_VENV[\"']?\$" "$GPR20_VENV/bin/activate"; then
        before_change "missing: ${gone:-$GPR20_VENV}"
        need_disk "$GPR20_ROOT" "$PYTHON_MB" "its Python packages"
        rm -rf "$GPR20_VENV"
        run_logged "the virtual environment $GPR20_VENV" \
            "$PYTHON" -m venv --system-site-packages "$GPR20_VENV"
        update_old_pip
        venv_is_new=yes
    fi
    for list in "${lists[@]}"; do
        list="$GPR20_ROOT/requirements/$list"
        if [ "$venv_is_new" = yes ] || ! is_installed "$list"; then
            arguments+=(-r "$list")
            inputs+=("$list")
            names+=("${list##*/}")
        fi
    done
    # Most surveys are analysed elsewhere than on the robot. gpr20 runs from its sources.
    if [ "$robot" = no ] || [ "$analysis" = yes ]; then
        for source in "gpr20_analysis[all]" gpr20_foreign_formats gpr20_viewer; do
            list="$GPR20_WORKSPACE/src/${source%[*}/pyproject.toml"
            # The workspace also works without the folders of the last two.
            [ -f "$list" ] || continue
            if [ "$venv_is_new" = yes ] || ! is_installed "$list"; then
                arguments+=(--editable "$GPR20_WORKSPACE/src/$source")
                inputs+=("$list")
                names+=("$source")
            fi
        done
    fi
    if [ ${#arguments[@]} -eq 0 ]; then
        [ -e "$GPR20_VENV/installed" ] || [ "$check" = yes ] ||
            in_environment >"$GPR20_VENV/installed"
        return 0
    fi
    before_change "missing Python packages of: ${names[*]} (pinned in ${pins##*/})"
    step "installing Python packages in .venv (typically 1 min)"
    run_logged "the installation of Python packages" \
        "$GPR20_VENV/bin/python" -m pip install --disable-pip-version-check --progress-bar off \
        --constraint "$pins" "${arguments[@]}"
    for list in "${inputs[@]}"; do cat "$list" "$pins" >"$(stamp_of "$list")"; done
    in_environment >"$GPR20_VENV/installed"
}

# What pip has put into the virtual environment: a name a line, sorted.
in_environment() {
    local folder
    for folder in "$GPR20_VENV"/lib/python3*/site-packages; do
        [ ! -d "$folder" ] || LC_ALL=C ls "$folder"
    done
}

# That of Ubuntu 20.04, 20.0.2, cannot install what has only a pyproject.toml as editable.
update_old_pip() {
    local version
    version="$("$GPR20_VENV/bin/python" -m pip --version | grep -oE '[0-9]+' | head -n 1)"
    [ "$version" -lt 22 ] || return 0
    run_logged "the update of pip" \
        "$GPR20_VENV/bin/python" -m pip install --disable-pip-version-check --upgrade pip
}

# What was installed last because of a list.
stamp_of() {
    local name="${1#"$GPR20_ROOT"/}"
    echo "$GPR20_VENV/installed-${name//\//-}"
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
        echo "$GPR20_ROOT"
        echo "ROS: $(ros_setup_file)")
}

build_workspace() {
    local stamp="$GPR20_WORKSPACE/build/inputs.sha256" inputs
    inputs="$(build_inputs)"
    if [ -f "$stamp" ] && [ "$inputs" = "$(cat "$stamp")" ]; then return 0; fi
    before_change "the catkin workspace is not built from these sources"
    step "building the catkin workspace (typically 30 s)"
    # The build names its folder and its ROS too.
    if ! grep -qsxF "CMAKE_HOME_DIRECTORY:INTERNAL=$GPR20_WORKSPACE/src" \
        "$GPR20_WORKSPACE/build/CMakeCache.txt" ||
        [ "$(tail -n 1 "$stamp" 2>/dev/null)" != "$(tail -n 1 <<<"$inputs")" ]; then
        rm -rf "$GPR20_WORKSPACE/build" "$GPR20_WORKSPACE/devel"
    fi
    run_logged "the catkin build" make_workspace
    printf '%s\n' "$inputs" >"$stamp"
}

# devel/setup.bash then sources that of the ROS which is sourced here.
make_workspace() {
    local ros
    ros="$(ros_setup_file)"
    (
        # What ROS generates reads variables that may not be set.
        set +u
        # shellcheck disable=SC1090
        [ -z "$ros" ] || source "$ros"
        catkin_make -C "$GPR20_WORKSPACE" -DPYTHON_EXECUTABLE="$GPR20_VENV/bin/python3" \
            -DCATKIN_ENABLE_TESTING=OFF
    )
    # The messages, whose first import would cost each node of the first launch 0.2 s.
    "$GPR20_VENV/bin/python" -m compileall -q "$GPR20_WORKSPACE/devel/lib/python3"
}

check_place
install_debian_packages
install_python_packages
build_workspace
