#!/usr/bin/env bash
# The steps of scripts/package_trial.sh, in its chroot: /old and /new are the two bundles.
#   package_trial_steps.sh PACKAGE
set -euo pipefail
package="$1"
surveys=/var/lib/gpr20/surveys
export DEBIAN_FRONTEND=noninteractive

say() { printf '== %4d s  %s\n' "$SECONDS" "$*"; }

fail() {
    echo "package_trial: $*" >&2
    exit 1
}

# use BUNDLE: the only source of packages.
use() {
    rm -f /etc/apt/sources.list /etc/apt/sources.list.d/*
    echo "deb [trusted=yes] file:/$1 ./" >/etc/apt/sources.list
    apt-get -q update
}

version_in() {
    awk -v wanted="$2" '$1 == "Package:" { own = $2 }
        $1 == "Version:" && own == wanted { print $2 }' "/$1/Packages"
}

# Kind, rights and owner of everything, and the contents of /etc, without what apt keeps.
tree() {
    find / -xdev \( -path /proc -o -path /dev -o -path /sys -o -path /tmp -o -path /root \
        -o -path /old -o -path /new -o -path /var/cache -o -path /var/lib/apt \
        -o -path /var/lib/dpkg \
        -o -path /var/lib/gpr20 -o -path /var/log -o -path /run \
        -o -path /var/lib/systemd/deb-systemd-helper-enabled \) -prune \
        -o -printf '%p %y %M %u %g %l\n' | sort
    find /etc -type f -not -name '*-' -exec sha256sum {} + | sort -k 2
}

# expect_release VERSION: what runs, and that programs of it start.
expect_release() {
    local found
    found="$(cat /opt/gpr20/current/release)"
    [ "$found" = "$1" ] || fail "current is $found, not $1"
    gpr20 --version
}

install() {
    local names
    names="$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' 'gpr20-*' 2>/dev/null |
        sed -n "s/^ii *\(.*\)/\1=$1/p" || true)"
    # shellcheck disable=SC2086
    apt-get -q install -y --no-install-recommends --allow-downgrades "$package=$1" $names
}

# survey: as its service, without the hardware, and verified.
survey() {
    local log=/tmp/robot.log service
    as_service setsid /opt/gpr20/current/deploy/gpr20-run robot >"$log" 2>&1 &
    service=$!
    until grep -q "/main_control is ready" "$log"; do
        kill -0 "$service" 2>/dev/null && [ "$SECONDS" -lt 1200 ] || {
            cat "$log"
            fail "the simulated robot did not start"
        }
        sleep 0.5
    done
    as_service gpr20-run ros rosrun gpr20_user_interface run_survey --x-points 3 --y-points 3
    pkill -INT -u gpr20 -f /usr/bin/roslaunch
    wait "$service" || true
    for stored in "$surveys"/2*; do gpr20 verify "$stored"; done
}

as_service() {
    runuser -u gpr20 -- env --ignore-environment HOME=/var/lib/gpr20 PATH=/usr/bin:/bin \
        ROS_LOG_DIR=/var/log/gpr20 \
        GPR20_LAUNCH_ARGUMENTS="robot:=simulated time_scale:=20" "$@"
}

# What people have changed, and what the robot has stored.
state() {
    find /etc/gpr20 "$surveys" -type f -exec sha256sum {} + 2>/dev/null | sort -k 2 || true
}

old="$(version_in old "$package")" new="$(version_in new "$package")"
before=/root/before after=/root/after
use old
say "install and purge, so that Debian's packages and the user are there"
install "$old"
apt-get -q purge -y 'gpr20-*'
tree >"$before"

say "install $package $old"
install "$old"
expect_release "$old"
if [ "$package" = gpr20-robot ]; then
    say "a survey, and a change of the configuration"
    survey
fi
if [ "$package" != gpr20-analysis ]; then
    sed -i 's/^GPR20_ADMIN=.*/GPR20_ADMIN=192.168.1.0\/24/' /etc/gpr20/environment
    echo 'site: trial' >>/etc/gpr20/robot/site.yaml
fi
state >/root/state

say "upgrade to $new"
use new
install "$new"
expect_release "$new"
state | diff /root/state - || fail "the upgrade changed configuration or surveys"
[ "$(cat /opt/gpr20/slots/?/release | sort | tr '\n' ' ')" = \
    "$(printf '%s\n' "$old" "$new" | sort | tr '\n' ' ')" ] || fail "the slots are not old and new"
if [ "$package" = gpr20-robot ]; then
    survey
    state >/root/state
fi

say "downgrade to $old"
use old
install "$old"
expect_release "$old"
state | diff /root/state - || fail "the downgrade changed configuration or surveys"

say "remove"
apt-get -q remove -y 'gpr20-*'
state | diff /root/state - || fail "the removal changed configuration or surveys"
[ ! -e /opt/gpr20 ] || fail "/opt/gpr20 is left: $(find /opt/gpr20 | head -n 5)"

say "purge; what is left:"
apt-get -q purge -y 'gpr20-*'
tree >"$after"
diff "$before" "$after" || fail "files, rights, users or contents of /etc differ"
[ ! -e /etc/gpr20 ] || fail "/etc/gpr20 is left"
if [ "$package" = gpr20-robot ]; then
    ls "$surveys" | grep -c . | xargs echo "surveys that are left:"
fi
say "as before the installation"
