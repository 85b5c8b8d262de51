#!/usr/bin/env bash
# Steps of scripts/bare_debian.sh that are more than one command. They run in its chroot, in a
# checkout where scripts/survey.sh has run. Each ends with status 0 if everything was as expected.
#   copied_space   a survey from a copy of the install space ~/space, while it and the checkout
#                  are elsewhere
#   doctor         beside a simulated robot, and with the robot off
set -euo pipefail

checkout="$PWD"
# Of the robot that a step starts; the chroot shares the network of the machine around it.
port="$(bash -c 'source scripts/environment.sh && gpr20_free_port')"
export ROS_MASTER_URI="http://127.0.0.1:$port"
log=~/launch.log launch=''

say() { printf '\n== %s\n' "$*"; }

fail() {
    echo "bare_debian_steps.sh: $*" >&2
    exit 1
}

# expect STATUS COMMAND...: run it, and end if its exit status is another.
expect() {
    local wanted="$1" status=0
    shift
    say "$*"
    "$@" || status=$?
    echo "-- exit status $status"
    [ "$status" -eq "$wanted" ] || fail "'$*' ended with status $status instead of $wanted"
}

# What setup.bash reads may be unset.
source_workspace() {
    set +u
    # shellcheck disable=SC1090
    source "$1/setup.bash"
    set -u
}

# start_robot ARGUMENT...: the simulated robot, until it can survey.
start_robot() {
    local deadline=$((SECONDS + 120))
    say "roslaunch gpr20 survey.launch ui:=false $*"
    setsid roslaunch -p "$port" gpr20 survey.launch ui:=false "$@" >"$log" 2>&1 &
    launch=$!
    until grep -q "/main_control is ready" "$log"; do
        if ! kill -0 "$launch" 2>/dev/null || [ "$SECONDS" -ge "$deadline" ]; then
            tail -n 30 "$log" >&2
            fail "the simulated robot did not start"
        fi
        sleep 0.2
    done
}

stop_robot() {
    [ -n "$launch" ] || return 0
    kill -INT "$launch" 2>/dev/null || true
    wait "$launch" 2>/dev/null || true
    launch=''
    ! grep -E 'Traceback|has died|\[ERROR\]|No module named' "$log" || fail "the log has errors"
}

# Nothing runs on, and everything is where it was.
clean_up() {
    local folder
    [ -z "$launch" ] || kill -INT "$launch" 2>/dev/null || true
    for folder in ~/space "$checkout"; do
        [ ! -d "$folder.away" ] || mv "$folder.away" "$folder"
    done
}

step_copied_space() {
    local data=~/copied_data
    say "copy ~/space to ~/copy; move ~/space and $checkout away"
    cp -r ~/space ~/copy
    mv ~/space ~/space.away
    mv "$checkout" "$checkout.away"
    cd ~
    source_workspace ~/copy
    start_robot time_scale:=20 "data:=$data"
    expect 0 rosrun gpr20_user_interface run_survey --x-points 3 --y-points 3
    stop_robot
    expect 0 gpr20 verify "$data"/*
    rm -r ~/copy
}

step_doctor() {
    source_workspace catkin_ws/devel
    export PATH="$checkout/.venv/bin:$PATH"
    start_robot "data:=$HOME/doctor_data"
    expect 0 gpr20 doctor --wait 60
    stop_robot
    expect 2 gpr20 doctor
    expect 3 gpr20 doctor --no-such-option
}

case "${1-}" in
    copied_space | doctor) ;;
    *) fail "name a step: copied_space or doctor" ;;
esac
trap clean_up EXIT
"step_$1"
