#!/usr/bin/env bash
# What the services of deploy/systemd run: one part of the robot, until a signal ends it.
#   deploy/run.sh server    the PC's part and the ROS master
#   deploy/run.sh robot     the robot's part, once the server's master runs
#   deploy/run.sh survey    both, on one machine
#   deploy/run.sh screen    in an X session: what is missing, then the window
#   deploy/run.sh window    the window, on the screen of DISPLAY
#   deploy/run.sh doctor    what is wrong with the robot and this machine; it ends by itself
#   deploy/run.sh accept_data   use another data folder in the place of the former one
# The environment is that of /etc/gpr20/environment:
#   GPR20_ROBOT, GPR20_SERVER   addresses of the two machines; both empty: one machine
#   GPR20_DATA, GPR20_CONFIG    folders of the surveys and of the configuration
#   GPR20_LAUNCH_ARGUMENTS      further arguments of roslaunch, such as robot:=simulated
#   GPR20_WINDOW_ARGUMENTS      further arguments of the window, such as _language:=es
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/../scripts/environment.sh"

part="${1-}" address=
case "$part" in
    server) address="${GPR20_SERVER-}" ;;
    robot) address="${GPR20_ROBOT-}" ;;
    # They say on the screen that the link is missing.
    survey | screen | window | doctor | accept_data) ;;
    *)
        echo "run.sh: '$part' is not one of server, robot, survey, screen, window, doctor," \
            "accept_data" >&2
        exit 2
        ;;
esac

has_address() {
    case " $(hostname -I) " in *" $1 "*) return 0 ;; esac
    return 1
}

# The nodes bind to this address when they start, so the link must be up.
wait_for_address() {
    if has_address "$1"; then return; fi
    echo "waiting until this machine has the address $1; connect the link and check its settings"
    until has_address "$1"; do sleep 1; done
}

# An address that was exported before counts, as everywhere.
if [ -n "$address" ] && [ -z "${ROS_IP-}${ROS_HOSTNAME-}" ]; then wait_for_address "$address"; fi
gpr20_use_workspace
read -ra launch_arguments <<<"robot:=gpr20 ${GPR20_LAUNCH_ARGUMENTS-}"
read -ra window_arguments <<<"--wait-for-display _full_screen:=true ${GPR20_WINDOW_ARGUMENTS-}"
follow="$GPR20_ROOT/deploy/follow_master.py"

case "$part" in
    server) exec roslaunch gpr20 server.launch "${launch_arguments[@]}" ;;
    survey) exec roslaunch gpr20 survey.launch "${launch_arguments[@]}" ui:=false ;;
    robot) exec python "$follow" roslaunch gpr20 robot.launch "${launch_arguments[@]}" ui:=false ;;
    screen)
        openbox &
        # Once more, because the link decides where the nodes listen.
        exec python "$GPR20_ROOT/deploy/waiting_screen.py" "$GPR20_ROOT/deploy/run.sh" window
        ;;
    window) exec rosrun gpr20_user_interface user_interface "${window_arguments[@]}" ;;
    doctor)
        # As roslaunch does, the last one counts.
        for argument in "${launch_arguments[@]}"; do
            case "$argument" in ns:=*) export ROS_NAMESPACE="${argument#ns:=}" ;; esac
        done
        exec rosrun gpr20_doctor doctor --wait "${2-30}"
        ;;
    accept_data)
        data=''
        for argument in "${launch_arguments[@]}"; do
            case "$argument" in data:=*) data="${argument#data:=}" ;; esac
        done
        exec rosrun gpr20_launch robot_config accept_data --data "$data"
        ;;
esac
