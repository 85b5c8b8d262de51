# Sourced by setup.sh: progress, errors, and a log of what apt, pip and catkin print.
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
