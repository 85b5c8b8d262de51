# Sourced by setup.sh: progress, errors, a log of what apt, pip and catkin print; which ROS is used,
# which packages of the system are missing, and apt.
# shellcheck shell=bash

# The log of this run; the first thing that is installed or built begins it.
setup_log="$GPR20_ROOT/setup.log"
log_begun=no
# Progress is shown even by what is logged.
exec 3>&1

step() {
    echo "setup: $*" >&3
}

fail() {
    echo "setup.sh: $*" >&2
    exit 1
}

# run_logged WHAT COMMAND...: run it; what it prints goes to the log. If it fails, print the end of
# the log, what may be the reason, and end.
run_logged() {
    local what="$1" first
    shift
    begin_log
    first=$(($(wc -l <"$setup_log") + 1))
    if try_logged "$@"; then return 0; fi
    tail -n "+$first" "$setup_log" | tail -n 15 >&2
    fail "$what failed; the lines above are the end of $setup_log
$(remedy <"$setup_log")"
}

# try_logged COMMAND...: run it; what it prints goes to the log.
try_logged() {
    begin_log
    printf '\n==> %s\n' "$*" >>"$setup_log"
    "$@" >>"$setup_log" 2>&1
}

begin_log() {
    [ "$log_begun" = no ] || return 0
    log_begun=yes
    date >"$setup_log"
    step "details are in $setup_log"
}

# What to do about an error, by what was printed.
remedy() {
    local printed
    printed="$(cat)"
    case "$printed" in
        *"No space left"* | *"not have enough free space"*)
            echo "The disk is full: free some space (df -h shows which disk), then run it again." ;;
        *"CERTIFICATE_VERIFY_FAILED"*)
            echo "The certificate of the server is not trusted: check the clock (date); behind a" \
                "company's proxy, set PIP_CERT to its certificate." ;;
        *"Temporary failure resolving"* | *"Could not resolve"* | *"Failed to fetch"* | \
            *"Name or service not known"* | *"Network is unreachable"* | *"Failed to establish"* | \
            *"Temporary failure in name resolution"* | *"Could not connect"*)
            echo "The network did not answer: check the connection, then run it again." ;;
        *"Unable to locate package"* | *"has no installation candidate"*)
            echo "This system does not offer a package; supported are Debian 12, and Ubuntu 20.04" \
                "with ROS Noetic in /opt/ros/noetic." ;;
        *"Could not get lock"* | *"Unable to acquire"*)
            echo "Another program is installing packages: run it again when that has finished." ;;
        *"dpkg was interrupted"*)
            echo "An earlier installation was interrupted; run as root: dpkg --configure -a" ;;
        *)
            echo "Fix what the lines above name, then run scripts/setup.sh again." ;;
    esac
}

# How long another installation is waited for [s], and how often apt is tried [s].
APT_WAIT_S="${GPR20_APT_WAIT_S:-900}"
APT_RETRY_S=2
# Where ROS Noetic is on Ubuntu 20.04.
ROS_PREFIX="${GPR20_ROS_PREFIX:-/opt/ros/noetic}"
OS_RELEASE=/etc/os-release

# The setup file of the system's ROS; empty where ROS is Debian's packages, which need none.
ros_setup_file() {
    if [ -f "$ROS_PREFIX/setup.bash" ]; then echo "$ROS_PREFIX/setup.bash"; fi
}

is_installed_package() {
    dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'ok installed'
}

# Print the packages to install: `missing_packages PACKAGE... -- DEBIAN_NAME:ros_name...`.
# With ROS in $ROS_PREFIX, none of ROS comes from Debian: what is missing there has a package
# ros-noetic-*.
missing_packages() {
    local package ros_name
    while [ "$1" != -- ]; do
        is_installed_package "$1" || echo "$1"
        shift
    done
    shift
    for package in "$@"; do
        ros_name="${package#*:}"
        if [ -z "$(ros_setup_file)" ]; then
            is_installed_package "${package%%:*}" || echo "${package%%:*}"
        elif [ ! -f "$ROS_PREFIX/share/$ros_name/package.xml" ]; then
            echo "ros-noetic-${ros_name//_/-}"
        fi
    done
}

# End with what to do if this system is none that apt can prepare.
require_supported_system() {
    local name version
    # shellcheck disable=SC1090
    name="$(. "$OS_RELEASE" 2>/dev/null && echo "${ID:-}")"
    # shellcheck disable=SC1090
    version="$(. "$OS_RELEASE" 2>/dev/null && echo "${VERSION_ID:-}")"
    if [ "$name $version" = "ubuntu 20.04" ] && [ -z "$(ros_setup_file)" ]; then
        fail "Ubuntu 20.04 needs ROS Noetic in $ROS_PREFIX: add the packages of packages.ros.org" \
            "and install ros-noetic-ros-base (https://wiki.ros.org/noetic/Installation/Ubuntu)," \
            "then run scripts/setup.sh again"
    fi
    command -v apt-get >/dev/null ||
        fail "apt-get is missing: this needs Debian 12, or Ubuntu 20.04 with ROS Noetic." \
            "Elsewhere use a container of Debian 12."
}

# Print how commands are run as root: nothing, sudo or a reason why they cannot be.
root_rights() {
    if [ "$(id -u)" -eq 0 ]; then
        echo root
    elif ! command -v sudo >/dev/null; then
        echo "you are $(id -un), not root, and sudo is not installed"
    elif sudo -n true 2>/dev/null; then
        echo sudo
    elif [ -t 0 ]; then
        echo "sudo with your password"
    else
        echo "you are $(id -un), and sudo asks for a password, for which there is no terminal"
    fi
}

# install_packages PACKAGE...: by apt, when nobody else installs something.
install_packages() {
    local rights
    require_supported_system
    rights="$(root_rights)"
    case "$rights" in
        root) as_root=() ;;
        sudo) as_root=(sudo) ;;
        "sudo with your password")
            as_root=(sudo)
            step "sudo may ask for your password, to install packages"
            sudo -v || fail "sudo refused; $(for_an_administrator "$@")" ;;
        *) fail "packages of the system are missing, but $rights; $(for_an_administrator "$@")" ;;
    esac
    need_disk /usr "$PACKAGES_MB" "the packages of the system"
    step "installing $# packages of the system (typically 2 min)"
    # Another source of packages than ours may be broken; what is missing fails below.
    try_logged run_apt update || step "apt-get update reported errors"
    run_logged "apt-get install" run_apt install -y --no-install-recommends "$@"
}

for_an_administrator() {
    echo "have root run"
    echo "  apt-get update && apt-get install -y --no-install-recommends $*"
    echo "then run scripts/setup.sh again."
}

# apt-get ARGUMENT..., as root. apt itself waits for only one of its locks (/var/lib/dpkg), not for
# that of `update`, so it is tried again while it says that somebody has one.
run_apt() {
    local printed holder said="" begin="$SECONDS"
    printed="$(mktemp)"
    while ! "${as_root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive \
        apt-get "$@" >"$printed" 2>&1; do
        holder="$(holder_of_lock <"$printed")"
        if [ -z "$holder" ] || [ $((SECONDS - begin)) -ge "$APT_WAIT_S" ]; then
            cat "$printed"
            rm -f "$printed"
            return 1
        fi
        [ "$holder" = "$said" ] ||
            step "waiting for $holder, which is installing packages (at most $APT_WAIT_S s)"
        said="$holder"
        sleep "$APT_RETRY_S"
    done
    cat "$printed"
    rm -f "$printed"
}

# Who has a lock of apt's or dpkg's, by what apt printed; empty if that was not the reason.
holder_of_lock() {
    local printed
    printed="$(cat)"
    grep -qE 'Could not get lock|Unable to (lock|acquire)' <<<"$printed" || return 0
    grep -oE 'held by process [0-9]+ \([^)]*\)' <<<"$printed" | head -n 1 |
        sed 's/held by //' | grep . || echo "another program"
}
