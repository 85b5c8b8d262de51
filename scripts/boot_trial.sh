#!/usr/bin/env bash
# For maintainers: boot the robot of one machine, installed from a bundle, with systemd as its first
# process (systemd-nspawn, no network): services, firewall, a survey, its end by `systemctl stop`,
# an update with its way back, and the power gone in the middle of one.
#   sudo scripts/boot_trial.sh OLD NEW SIGNERS
#     OLD, NEW   bundles (scripts/bundle.sh)
#     SIGNERS    line of who signed them, for /etc/gpr20/release_signers
# Status 0 if everything was as expected. Needs the network once, for systemd itself.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
# shellcheck source=scripts/steps/chroot.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/chroot.sh"

fail() {
    echo "boot_trial.sh: $*" >&2
    exit 1
}

[ $# -eq 3 ] && [ -f "$1/Packages" ] && [ -f "$2/Packages" ] && [ -f "$3" ] ||
    fail "name two bundles and the file with the line of who signed them"
old="$(realpath "$1")" new="$(realpath "$2")" signers="$(realpath "$3")"
require_chroot
command -v systemd-nspawn >/dev/null ||
    fail "systemd-nspawn is missing; run: apt-get install systemd-container"
root="$folder/boot" log="$folder/boot.log" container=''
begin="$(date +%s)"

say() { printf '== %4d s  %s\n' $(($(date +%s) - begin)) "$*"; }

# in_root COMMAND: before it boots.
in_root() {
    enter_root "$root" "${@:2}" -- bash -ec 'mount --bind "$2" "$1/mnt"
        env --ignore-environment HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin \
            DEBIAN_FRONTEND=noninteractive chroot "$1" bash -ec "$3"' \
        bash "$root" "$old" "$1" >>"$log" 2>&1
}

boot() {
    systemd-nspawn --quiet -D "$root" --boot --private-network --register=no --keep-unit \
        --bind-ro="$old:/media/old" --bind-ro="$new:/media/new" >>"$log" 2>&1 &
    container=$!
    until inside 'systemctl is-active -q gpr20-robot' 2>/dev/null; do
        kill -0 "$container" 2>/dev/null || fail "the system did not boot; see $log"
        sleep 1
    done
    ready
}

# power_off: nothing is written or ended any more.
power_off() {
    kill -KILL "$(init_of_container)" 2>/dev/null || true
    wait "$container" 2>/dev/null || true
}

init_of_container() { pgrep -P "$container" | head -n 1; }

# inside COMMAND: in the booted system, as root.
inside() {
    local init
    init="$(init_of_container)"
    nsenter --target "$init" --mount --uts --ipc --net --pid --root \
        --wd="/proc/$init/root" \
        env --ignore-environment HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin bash -c "$1"
}

# expect WHAT COMMAND: a command of the booted system that must succeed.
expect() {
    inside "$2" >>"$log" 2>&1 || fail "$1: '$2' failed; see $log"
    say "$1"
}

# ready: since its last start the robot's service has begun to listen.
ready() {
    inside 'for _ in $(seq 120); do
            systemctl is-active -q gpr20-robot || { sleep 1; continue; }
            since="$(systemctl show -P ActiveEnterTimestamp gpr20-robot)"
            journalctl -q -u gpr20-robot --since "$since" | grep -q "/main_control is ready" &&
                exit 0
            sleep 1
        done
        exit 1' || fail "the robot's service is not ready; see journalctl in $root"
}

release_is() { inside "grep -qx '$1' /opt/gpr20/current/release"; }

version_of() {
    awk '$1 == "Package:" { own = $2 } $1 == "Version:" && own == "gpr20-software" { print $2 }' \
        "$1/Packages"
}

# survey WHAT [ARGUMENT]: without an argument of 18 traces.
survey() {
    expect "$1" "runuser -u gpr20 -- gpr20-run ros rosrun gpr20_user_interface run_survey \
        --wait 60 ${2:---x-points 3 --y-points 3}"
}

clean_up() {
    [ -z "$container" ] || power_off
    rm -rf --one-file-system "$root"
}

: >"$log"
make_base
make_root boot
trap clean_up EXIT
in_root 'apt-get update && apt-get install -y --no-install-recommends systemd-sysv procps'
# The packages of a trial know no signer yet, so the script ends with status 1 after installing.
in_root 'rm -f /etc/resolv.conf
    sh /mnt/install.sh gpr20-robot || dpkg -s gpr20-robot | grep -q " installed$"' --net
rm "$root/usr/sbin/policy-rc.d"
cat "$signers" >>"$root/etc/gpr20/release_signers"
in_root 'gpr20-update /mnt' --net
sed -i 's/^\(GPR20_LAUNCH_ARGUMENTS=robot:=simulated\)$/\1 time_scale:=20/' \
    "$root/etc/gpr20/environment"
say "installed from the bundle, $(du -sm "$root" | cut -f 1) MB"

boot
say "booted: firewall and robot are active"
release_is "$(version_of "$old")" || fail "the old version does not run"
survey "a survey through the service"
expect "the doctor finds no fault" 'runuser -u gpr20 -- gpr20-run doctor --wait 30; [ $? -le 1 ]'

inside 'runuser -u gpr20 -- gpr20-run ros rosrun gpr20_user_interface run_survey --x-points 12' \
    >>"$log" 2>&1 &
client=$!
newest='$(ls -d /var/lib/gpr20/surveys/2* | tail -n 1)'
expect "five traces of another survey" \
    "until [ \"\$(ls -d /var/lib/gpr20/surveys/2* | wc -l)\" -eq 2 ] &&
        [ \"\$(ls $newest/traces | wc -l)\" -ge 5 ]; do sleep 0.2; done"
expect "gpr20-update refuses during a survey" '! gpr20-update /media/new 2>/tmp/said &&
    grep -q survey /tmp/said'
expect "systemctl stop" 'systemctl stop gpr20-robot && systemctl start gpr20-robot'
wait "$client" || true
ready
survey "the survey is resumed" "--resume \$(basename $newest)"
expect "both surveys are complete and intact" \
    'for one in /var/lib/gpr20/surveys/2*; do gpr20 verify "$one" || exit 1; done'

expect "gpr20-update to the new version" 'gpr20-update /media/new'
release_is "$(version_of "$new")" || fail "the new version does not run"
survey "a survey of the new version"
expect "gpr20-update --back" 'gpr20-update --back'
release_is "$(version_of "$old")" || fail "the old version does not run"
ready

say "the power goes while the update installs"
inside 'setsid gpr20-update /media/new >/tmp/update.log 2>&1 &
    update=$!
    until pgrep -x dpkg >/dev/null; do kill -0 $update || exit 1; sleep 0.05; done
    sleep 2' || fail "the update did not begin: $(inside 'cat /tmp/update.log')"
power_off
boot
expect "after the cut the update is at an end" 'systemctl is-active gpr20-robot &&
    ! gpr20-update --status | grep UNFINISHED && dpkg --audit'
say "it runs $(inside 'cat /opt/gpr20/current/release')"
survey "a survey after the cut"

inside 'sed -i "s/^GPR20_ROBOT=.*/GPR20_ROBOT=10.20.0.1/
    s/^GPR20_SERVER=.*/GPR20_SERVER=10.20.0.2/" /etc/gpr20/environment'
expect "without GPR20_ADMIN neither firewall nor robot start" '! systemctl restart gpr20-firewall &&
    ! systemctl is-active -q gpr20-robot'
inside 'sed -i "s/^GPR20_ADMIN=.*/GPR20_ADMIN=none/" /etc/gpr20/environment'
expect "with it both do" 'systemctl restart gpr20-firewall gpr20-robot'
for action in start restart reload stop; do
    expect "systemctl $action nftables leaves the rules" \
        "systemctl $action nftables && nft list table inet gpr20 | grep -q 10.20.0.2"
done
say "everything was as expected"
