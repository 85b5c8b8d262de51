#!/usr/bin/env bash
# For maintainers: run the README's commands, the install space, the doctor and the installation of
# the services on a bare Debian 12, as root and as a user with sudo.
#   scripts/bare_debian.sh                      the commands of COMMANDS below
#   scripts/bare_debian.sh --tests              all tests as well
#   scripts/bare_debian.sh --as root|user       only as one of the two
#   scripts/bare_debian.sh [options] COMMAND... these commands instead, one argument each
#   scripts/bare_debian.sh --keep               leave the chroots for a look
# A chroot gets a clean clone of HEAD in the home of who runs the commands. Needs root, debootstrap
# and the network. Everything is in one folder; only the system without packages, `base`, is kept.
#   GPR20_BARE_DEBIAN   this folder (default /var/tmp/gpr20_bare_debian)
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

RELEASE=bookworm
MIRROR=http://deb.debian.org/debian
LIMIT_S=5400
# Run in this order in the checkout.
COMMANDS=(
    "scripts/survey.sh"
    "scripts/setup.sh --check"
    "scripts/install_space.sh ~/space"
    "scripts/steps/bare_debian_steps.sh copied_space"
    "scripts/steps/bare_debian_steps.sh doctor"
    "scripts/steps/bare_debian_steps.sh services"
)

folder="$(realpath -ms "${GPR20_BARE_DEBIAN:-/var/tmp/gpr20_bare_debian}")"
people=(root user) keep=no tests=no commands=()
while [ $# -gt 0 ]; do
    case "$1" in
        --as) people=("${2:?--as needs root or user}"); shift ;;
        --keep) keep=yes ;;
        --tests) tests=yes ;;
        -*) echo "bare_debian.sh: unknown option '$1'; its first lines list them" >&2; exit 2 ;;
        *) commands+=("$1") ;;
    esac
    shift
done
[ ${#commands[@]} -gt 0 ] || commands=("${COMMANDS[@]}")
[ "$tests" = no ] || commands+=("scripts/test.sh")

require() {
    if [ "$(id -u)" -ne 0 ]; then
        echo "bare_debian.sh: a chroot needs root; run: sudo scripts/bare_debian.sh" >&2
        exit 1
    fi
    if ! command -v debootstrap >/dev/null; then
        echo "bare_debian.sh: debootstrap is missing; run: apt-get install debootstrap" >&2
        exit 1
    fi
}

# The system before anything was installed on it; made once.
make_base() {
    [ ! -d "$folder/base" ] || return 0
    echo "making $folder/base (about 2 min)"
    rm -rf --one-file-system "$folder/base.new"
    if ! debootstrap --variant=minbase "$RELEASE" "$folder/base.new" "$MIRROR" \
        >"$folder/debootstrap.log" 2>&1; then
        tail "$folder/debootstrap.log" >&2
        echo "bare_debian.sh: debootstrap failed; its log is $folder/debootstrap.log" >&2
        exit 1
    fi
    mv "$folder/base.new" "$folder/base"
}

# make_chroot WHO: a copy of it with a clone of HEAD; the network is that of this machine.
make_chroot() {
    local root="$folder/$1" home
    rm -rf --one-file-system "$root"
    cp -a --reflink=auto "$folder/base" "$root"
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    # Like every installed system; its own name stays unknown.
    echo "127.0.0.1 localhost" >"$root/etc/hosts"
    # A machine behind a proxy has certificates of its own.
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/certificates_of_the_host.crt"
    # No package starts a program here: chrony would set the clock of this machine.
    printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
    chmod 755 "$root/usr/sbin/policy-rc.d"
    if [ "$1" = user ]; then
        chroot "$root" sh -ec "apt-get update && apt-get install -y --no-install-recommends sudo
            useradd --create-home --shell /bin/bash user
            echo 'user ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/user
            echo 'Defaults env_keep += \"PIP_CERT http_proxy https_proxy no_proxy\"' \
                >>/etc/sudoers.d/user" >"$folder/sudo.log" 2>&1
        rm -rf "$root"/var/lib/apt/lists/* "$root"/var/cache/apt/*
    fi
    home="$(home_of "$1")"
    git clone --quiet "$GPR20_ROOT" "$root$home/gpr20"
    chroot "$root" chown -R "$1:" "$home/gpr20"
}

home_of() {
    if [ "$1" = root ]; then echo /root; else echo "/home/$1"; fi
}

# run_in_chroot WHO COMMAND LOG: with /proc, /sys and /dev/shm, which go with its last process, and
# without a name of the machine, a locale and anything of the environment of this shell.
run_in_chroot() {
    local root="$folder/$1" home
    home="$(home_of "$1")"
    # shellcheck disable=SC2016
    timeout "$LIMIT_S" unshare --mount --pid --fork --kill-child --uts \
        bash -ec 'hostname bare-debian
            mount -t proc proc "$1/proc"
            mount -t sysfs sysfs "$1/sys"
            mkdir -p "$1/dev/shm"
            mount -t tmpfs tmpfs "$1/dev/shm"
            # Not exec: this shell is the init of the chroot, which collects orphans.
            status=0
            env --ignore-environment HOME="$3" USER="$2" PATH=/usr/bin:/bin:/usr/sbin:/sbin \
                "${@:5}" chroot --userspec="$2:$2" --groups="$2" "$1" \
                bash -c "cd ~/gpr20 && $4" || status=$?
            exit "$status"' \
        bash "$root" "$1" "$home" "$2" "${network[@]}" </dev/null >"$3" 2>&1
}

# How pip reaches the network here.
network=(PIP_CERT=/etc/certificates_of_the_host.crt)
for name in http_proxy https_proxy no_proxy; do
    [ -z "${!name:-}" ] || network+=("$name=${!name}")
done

used_mb() {
    du -sxm "$1" | cut -f1
}

# run_all WHO: run the commands; a line of the table for each.
run_all() {
    local who="$1" number=0 command before after begin status log
    for command in "${commands[@]}"; do
        number=$((number + 1))
        log="$folder/$who-$number.log"
        before="$(used_mb "$folder/$who")"
        begin="$(date +%s)"
        status=0
        run_in_chroot "$who" "$command" "$log" || status=$?
        after="$(used_mb "$folder/$who")"
        printf '%-5s %6d s %6d MB %+6d MB  %-10s %s\n' "$who" $(($(date +%s) - begin)) "$after" \
            $((after - before)) "$([ "$status" -eq 0 ] && echo passed || echo "status $status")" \
            "$command"
        if [ "$status" -ne 0 ]; then
            failed=yes
            tail -n 30 "$log" >&2
            return
        fi
    done
}

remove_chroots() {
    [ "$keep" = yes ] || rm -rf --one-file-system "$folder/root" "$folder/user"
}

require
mkdir -p "$folder"
trap remove_chroots EXIT
make_base
failed=no
echo "as      time      disk    change  result     command"
for who in "${people[@]}"; do
    make_chroot "$who"
    run_all "$who"
done
echo "the output of each command is in $folder/*.log"
[ "$failed" = no ]
