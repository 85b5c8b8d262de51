#!/usr/bin/env bash
# Steps of scripts/bare_debian.sh that are more than one command. They run in its chroot, in a
# checkout where scripts/survey.sh has run. Each ends with status 0 if everything was as expected.
#   copied_space   a survey from a copy of the install space ~/space, while it and the checkout
#                  are elsewhere
#   doctor         beside a simulated robot, and with the robot off
#   services       install_server.sh and install_robot.sh: --dry-run, installation, --uninstall,
#                  what is left
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
    say "${*/as_root/sudo}"
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

# As root, or as a user with sudo.
as_root() { if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi; }

# Kind, rights and owner of everything outside of homes, and the contents of /etc, without what apt
# keeps and the copies that are made of the lists of users and groups.
tree() {
    as_root find / -xdev \( -path /proc -o -path /dev -o -path /tmp -o -path /root -o -path /home \
        -o -path /opt/gpr20 -o -path /var/cache -o -path /var/lib/apt -o -path /var/lib/dpkg \
        -o -path /run/sudo -o -path /var/log/apt \) -prune -o -printf '%p %y %M %u %g %l\n' | sort
    as_root find /etc -type f -not -name '*-' -exec sha256sum {} + | sort -k 2
}

# install_and_uninstall SCRIPT ARGUMENT...: as docs/install.md says.
install_and_uninstall() {
    local script="scripts/$1" before after
    shift
    cd /opt/gpr20
    before="$(mktemp)" after="$(mktemp)"
    tree >"$before"
    expect 0 "$script" "$@" --dry-run
    tree | diff "$before" - || fail "--dry-run changed something"
    expect 0 as_root "$script" "$@"
    # Packages stay, and are there before the second installation.
    expect 0 as_root "$script" --uninstall
    as_root rm -rf /etc/gpr20
    tree >"$before"
    expect 0 as_root "$script" "$@"
    expect 0 as_root "$script" "$@"
    expect 0 as_root "$script" --uninstall
    expect 0 as_root "$script" --uninstall
    tree >"$after"
    say "what $script left"
    ! diff "$before" "$after" >"$log" || fail "the robot's configuration is not left"
    grep '^[<>]' "$log"
    if grep '^[<>]' "$log" | grep -vE '^> ([0-9a-f]{64}  )?/etc/gpr20(/robot|$| )'; then
        fail "$script --uninstall left more than the robot's configuration, or removed too much"
    fi
    as_root rm -rf /etc/gpr20
}

step_services() {
    local link=(--robot 10.20.0.1 --server 10.20.0.2 --admin 192.168.1.0/24)
    say "git clone $checkout /opt/gpr20"
    as_root apt-get install -y -qq --no-install-recommends git systemd >"$log" 2>&1 ||
        { cat "$log" >&2; fail "apt-get did not install git and systemd"; }
    as_root git clone --quiet "$checkout" /opt/gpr20
    install_and_uninstall install_server.sh "${link[@]}"
    install_and_uninstall install_robot.sh --one-machine
    say "id gpr20"
    ! id gpr20 || fail "the user gpr20 is left"
}

case "${1-}" in
    copied_space | doctor | services) ;;
    *) fail "name a step: copied_space, doctor or services" ;;
esac
trap clean_up EXIT
"step_$1"
