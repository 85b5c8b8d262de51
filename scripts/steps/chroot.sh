# Sourced by bare_debian.sh and package_trial.sh: chroots of a bare Debian 12, all in one folder, of
# which only the system without packages, `base`, is kept.
#   GPR20_BARE_DEBIAN   this folder (default /var/tmp/gpr20_bare_debian)
# shellcheck shell=bash

RELEASE=bookworm
MIRROR=http://deb.debian.org/debian
folder="$(realpath -ms "${GPR20_BARE_DEBIAN:-/var/tmp/gpr20_bare_debian}")"

require_chroot() {
    local name
    name="$(basename "$0")"
    if [ "$(id -u)" -ne 0 ]; then
        echo "$name: a chroot needs root; run: sudo scripts/$name" >&2
        exit 1
    fi
    if ! command -v debootstrap >/dev/null; then
        echo "$name: debootstrap is missing; run: apt-get install debootstrap" >&2
        exit 1
    fi
    mkdir -p "$folder"
}

# The system before anything was installed on it; made once.
make_base() {
    [ ! -d "$folder/base" ] || return 0
    echo "making $folder/base (about 2 min)"
    rm -rf --one-file-system "$folder/base.new"
    if ! debootstrap --variant=minbase "$RELEASE" "$folder/base.new" "$MIRROR" \
        >"$folder/debootstrap.log" 2>&1; then
        tail "$folder/debootstrap.log" >&2
        echo "$(basename "$0"): debootstrap failed; its log is $folder/debootstrap.log" >&2
        exit 1
    fi
    mv "$folder/base.new" "$folder/base"
}

# make_root NAME: a copy of it, with the network of this machine.
make_root() {
    local root="$folder/$1"
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
}

# enter_root ROOT UNSHARE_OPTION... -- COMMAND...: run a command that may use chroot, with /proc,
# /sys and /dev/shm, which go with its last process, and without a name of the machine.
enter_root() {
    local root="$1" options=()
    shift
    while [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    # shellcheck disable=SC2016
    unshare --mount --pid --fork --kill-child --uts "${options[@]}" \
        bash -ec 'hostname bare-debian
            mount -t proc proc "$1/proc"
            mount -t sysfs sysfs "$1/sys"
            mkdir -p "$1/dev/shm"
            mount -t tmpfs tmpfs "$1/dev/shm"
            # Not exec: this shell is the init of the chroot, which collects orphans.
            status=0
            "${@:2}" || status=$?
            exit "$status"' bash "$root" "${@:2}"
}
