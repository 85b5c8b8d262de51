#!/usr/bin/env bash
# For maintainers: a bare Debian 12 without a network gets the robot of one machine from a stick:
# install and purge, then, booted with systemd as its first process (systemd-nspawn), services,
# firewall, roles, surveys, an update with its way back, and the power gone in the middle of one.
#   sudo scripts/package_trial.sh OLD NEW     two sticks (scripts/stick.sh)
# Status 0 if everything was as expected. Needs the network once, for Debian itself.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
# shellcheck source=scripts/steps/chroot.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/chroot.sh"

fail() {
    echo "package_trial.sh: $*" >&2
    exit 1
}

[ $# -eq 2 ] && [ -f "$1/InRelease" ] && [ -f "$2/InRelease" ] ||
    fail "name the folders of two sticks"
old="$(realpath "$1")" new="$(realpath "$2")"
require_chroot
command -v systemd-nspawn >/dev/null ||
    fail "systemd-nspawn is missing; run: apt-get install systemd-container"
root="$folder/trial" log="$folder/package_trial.log" container=''
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
    until inside 'systemctl is-active -q gpr20' 2>/dev/null; do
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
    inside "$2" >>"$log" 2>&1 || {
        inside "journalctl --no-pager -n 40 -u 'gpr20*'" >>"$log" 2>&1 || true
        fail "$1: '$2' failed; see $log"
    }
    say "$1"
}

# ready: since its last start the robot's service has begun to listen.
ready() {
    inside 'for _ in $(seq 120); do
            systemctl is-active -q gpr20 || { sleep 1; continue; }
            since="$(systemctl show -P ActiveEnterTimestamp gpr20)"
            journalctl -q -u gpr20 --since "$since" | grep -q "/main_control is ready" &&
                exit 0
            sleep 1
        done
        exit 1' || fail "the robot's service is not ready; see journalctl in $root"
}

release_is() { inside "grep -qx '$1' /opt/gpr20/current/release"; }

version_of() { sed -n '/^Package: gpr20$/,/^$/s/^Version: //p' "$1/Packages"; }

# Kind, rights and owner of everything, and the contents of /etc, without what apt keeps.
tree() {
    (
        cd "$root"
        find . -xdev \( -path ./proc -o -path ./dev -o -path ./sys -o -path ./tmp -o -path ./root \
            -o -path ./var/cache -o -path ./var/lib/apt -o -path ./var/lib/dpkg \
            -o -path ./var/lib/gpr20 -o -path ./var/log -o -path ./run \
            -o -path ./var/lib/systemd/deb-systemd-helper-enabled \) -prune \
            -o -printf '%p %y %M %u %g %l\n' | sort
        find etc -type f -not -name '*-' -exec sha256sum {} + | sort -k 2
    ) >"$1"
}

# What people have changed, and what the robot has stored.
state() {
    (cd "$root" && find etc/gpr20 var/lib/gpr20/surveys -type f -exec sha256sum {} + | sort -k 2)
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
make_root trial
trap clean_up EXIT
in_root 'apt-get update && apt-get install -y --no-install-recommends systemd-sysv procps'
rm "$root/etc/resolv.conf"
say "a bare Debian, $(du -sm "$root" | cut -f 1) MB"
in_root 'sh /mnt/install.sh' --net
say "installed from the stick, $(du -sm "$root" | cut -f 1) MB"
in_root 'apt-get purge -y gpr20' --net
tree "$folder/before"
# The rest of the first installation: Debian's packages, and the user.
in_root 'sh /mnt/install.sh' --net
echo 'site: trial' >>"$root/etc/gpr20/robot/site.yaml"
mkdir -p "$root/var/lib/gpr20/surveys/kept"
touch "$root/var/lib/gpr20/surveys/kept/trace"
before="$(state)"
in_root 'apt-get remove -y gpr20' --net
[ "$before" = "$(state)" ] || fail "the removal changed configuration or surveys"
[ ! -e "$root/opt/gpr20" ] || fail "/opt/gpr20 is left"
in_root 'apt-get purge -y gpr20' --net
tree "$folder/after"
diff "$folder/before" "$folder/after" >&2 ||
    fail "files, rights, users or /etc differ after a purge"
rm -r "$root/var/lib/gpr20/surveys/kept"
say "removed and purged: only surveys and their user are left"

in_root 'sh /mnt/install.sh' --net
rm "$root/usr/sbin/policy-rc.d"
settings="$root/etc/gpr20/robot.conf"
sed -i 's/^\(GPR20_LAUNCH_ARGUMENTS=robot:=simulated\)$/\1 time_scale:=20/
    s/^GPR20_ROLE=.*/GPR20_ROLE=both/' "$settings"

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
expect "systemctl stop" 'systemctl stop gpr20 && systemctl start gpr20'
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
expect "after the cut the update is at an end" 'systemctl is-active gpr20 &&
    ! gpr20-update --status | grep UNFINISHED && dpkg --audit'
say "it runs $(inside 'cat /opt/gpr20/current/release')"
survey "a survey after the cut"

# role ROLE ROBOT SERVER ADMIN
role() {
    inside "sed -i 's/^GPR20_ROLE=.*/GPR20_ROLE=$1/; s/^GPR20_ROBOT=.*/GPR20_ROBOT=${2-}/
        s/^GPR20_SERVER=.*/GPR20_SERVER=${3-}/; s/^GPR20_ADMIN=.*/GPR20_ADMIN=${4-}/' \
        /etc/gpr20/robot.conf; systemctl stop gpr20"
}

for one in '' analysis; do
    role "$one"
    expect "nothing starts with the role '$one'" \
        'systemctl restart gpr20-firewall gpr20 gpr20-window && ! systemctl is-active gpr20 &&
            ! systemctl is-failed gpr20 && ! nft list table inet gpr20'
done
role both 10.20.0.1 10.20.0.2 none
expect "the role both with addresses is refused" '! systemctl restart gpr20-firewall'
role robot 10.20.0.1 10.20.0.2
expect "without GPR20_ADMIN neither firewall nor robot start" '! systemctl restart gpr20-firewall &&
    ! systemctl start gpr20 && ! systemctl is-active -q gpr20'
role robot 10.20.0.1 10.20.0.2 none
expect "with it both do, and the PC's clock is followed" 'systemctl restart gpr20-firewall gpr20 &&
    grep -q "^server 10.20.0.2 " /etc/chrony/sources.d/gpr20.sources'
for action in start restart reload stop; do
    expect "systemctl $action nftables leaves the rules" \
        "systemctl $action nftables && nft list table inet gpr20 | grep -q 10.20.0.2"
done
say "everything was as expected"
