# Where ROS listens. ROS 1 has no authentication, so it listens on loopback alone unless two machines
# are configured:
#   GPR20_ROBOT, GPR20_SERVER   addresses of the two machines on their own link; the master runs on
#                               the server
# Values that the user exported stay. Values that this file set when it was sourced before do not:
#   GPR20_SET_ROS_IP, GPR20_SET_MASTER   those values

_gpr20_is_address() {
    _gpr20_octet='(25[0-5]|2[0-4][0-9]|1[0-9][0-9]|[1-9]?[0-9])'
    case "$1" in *[!0-9.]*) return 1 ;; esac # a line break too, which grep would not show
    printf '%s\n' "$1" | grep -Eq "^($_gpr20_octet\.){3}$_gpr20_octet\$"
}

# Which of the two machines this is, by its addresses.
_gpr20_own_address() {
    for _gpr20_address in "$GPR20_ROBOT" "$GPR20_SERVER"; do
        case " $(hostname -I) " in *" $_gpr20_address "*) echo "$_gpr20_address"; return ;; esac
    done
}

# ROS takes ROS_HOSTNAME before ROS_IP.
_gpr20_listen_at() {
    if [ -z "${ROS_HOSTNAME:-}" ] && [ -z "${ROS_IP:-}" ]; then
        export ROS_IP="$1" GPR20_SET_ROS_IP="$1"
    fi
}

_gpr20_forget_own() {
    if [ "${ROS_IP:-}" = "${GPR20_SET_ROS_IP:-}" ]; then unset ROS_IP; fi
    if [ "${ROS_MASTER_URI:-}" = "${GPR20_SET_MASTER:-}" ]; then
        export ROS_MASTER_URI=http://localhost:11311
    fi
    unset GPR20_SET_ROS_IP GPR20_SET_MASTER
}

_gpr20_listen() {
    if [ -z "${GPR20_ROBOT:-}" ] && [ -z "${GPR20_SERVER:-}" ]; then
        _gpr20_listen_at 127.0.0.1
        case "${ROS_HOSTNAME:-$ROS_IP}" in
            localhost | 127.*) ;;
            *) echo "gpr20: ROS_HOSTNAME '${ROS_HOSTNAME:-}' or ROS_IP '${ROS_IP:-}' was exported" \
                "before: ROS listens to every machine that reaches this one, and has no" \
                "authentication. Unset both, or configure two machines by GPR20_ROBOT and" \
                "GPR20_SERVER; see docs/install.md." >&2 ;;
        esac
        return
    fi
    for _gpr20_address in "${GPR20_ROBOT:-}" "${GPR20_SERVER:-}"; do
        if ! _gpr20_is_address "$_gpr20_address"; then
            echo "gpr20: GPR20_ROBOT is '${GPR20_ROBOT:-}', GPR20_SERVER is" \
                "'${GPR20_SERVER:-}'; both must be addresses of four numbers, such as 10.20.0.1." \
                "Set both or none, and source this again; until then everything stays on" \
                "loopback." >&2
            unset ROS_IP ROS_HOSTNAME
            _gpr20_listen_at 127.0.0.1
            return
        fi
    done
    _gpr20_address="$(_gpr20_own_address)"
    if [ -z "$_gpr20_address" ] && [ -z "${ROS_IP:-}${ROS_HOSTNAME:-}" ]; then
        echo "gpr20: this machine has neither the address $GPR20_ROBOT (GPR20_ROBOT) nor" \
            "$GPR20_SERVER (GPR20_SERVER), but $(hostname -I). Correct them, or bring up the link," \
            "and source this again; until then its nodes listen on loopback alone." >&2
    fi
    _gpr20_listen_at "${_gpr20_address:-127.0.0.1}"
    # What ROS sets when nothing was said.
    if [ "${ROS_MASTER_URI:-http://localhost:11311}" = http://localhost:11311 ]; then
        GPR20_SET_MASTER="http://$GPR20_SERVER:11311"
        export GPR20_SET_MASTER ROS_MASTER_URI="$GPR20_SET_MASTER"
    fi
}

_gpr20_forget_own
_gpr20_listen
unset -f _gpr20_is_address _gpr20_own_address _gpr20_listen_at _gpr20_forget_own _gpr20_listen
unset _gpr20_address _gpr20_octet
