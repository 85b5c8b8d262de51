# Where ROS listens. ROS 1 has no authentication: unless two machines are configured explicitly, on loopback alone.
#   GPR20_ROBOT, GPR20_SERVER   addresses of the two machines on their own link; the master runs on the server

_gpr20_is_address() {
    printf '%s\n' "$1" | grep -Eq '^((25[0-5]|2[0-4][0-9]|1?[0-9]?[0-9])(\.|$)){4}$'
}

# Which of the two machines this is, by its addresses; loopback stands for both.
_gpr20_own_address() {
    for _gpr20_address in "$GPR20_ROBOT" "$GPR20_SERVER"; do
        case " $(hostname -I) " in *" $_gpr20_address "*) echo "$_gpr20_address"; return ;; esac
    done
}

_gpr20_listen() {
    if [ -z "${GPR20_ROBOT:-}" ] && [ -z "${GPR20_SERVER:-}" ]; then
        [ -n "${ROS_HOSTNAME:-}" ] || export ROS_IP="${ROS_IP:-127.0.0.1}"
        return
    fi
    for _gpr20_address in "${GPR20_ROBOT:-}" "${GPR20_SERVER:-}"; do
        if ! _gpr20_is_address "$_gpr20_address"; then
            echo "gpr20: GPR20_ROBOT is '${GPR20_ROBOT:-}', GPR20_SERVER is '${GPR20_SERVER:-}'; both must be addresses of four numbers," \
                "such as 10.20.0.1. Set both or none; until then everything stays on loopback." >&2
            export ROS_IP=127.0.0.1
            return
        fi
    done
    if [ -z "${ROS_IP:-}" ]; then
        ROS_IP="$(_gpr20_own_address)"
        if [ -z "$ROS_IP" ]; then
            echo "gpr20: this machine has neither the address $GPR20_ROBOT (GPR20_ROBOT) nor $GPR20_SERVER (GPR20_SERVER)," \
                "but $(hostname -I). Correct them, or bring up the link; until then everything stays on loopback." >&2
            ROS_IP=127.0.0.1
        fi
        export ROS_IP
    fi
    # What ROS sets when nothing was said.
    if [ "${ROS_MASTER_URI:-http://localhost:11311}" = http://localhost:11311 ]; then
        export ROS_MASTER_URI="http://$GPR20_SERVER:11311"
    fi
}

_gpr20_listen
unset -f _gpr20_is_address _gpr20_own_address _gpr20_listen
unset _gpr20_address
