#!/usr/bin/env bash
# For maintainers: run the README's commands and the install space on a bare Debian 12, as root and
# as a user with sudo.
#   scripts/bare_debian.sh              the commands of COMMANDS below
#   scripts/bare_debian.sh COMMAND...   these commands instead, one argument each
# A chroot gets a clean clone of HEAD in the home of who runs the commands. Needs root, debootstrap
# and the network. Everything is in the folder of steps/chroot.sh.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
# shellcheck source=scripts/steps/chroot.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/chroot.sh"

LIMIT_S=5400
# Run in this order in the checkout.
COMMANDS=(
    "scripts/survey.sh"
    "scripts/setup.sh --check"
    "scripts/install_space.sh ~/space"
    "source ~/space/setup.bash && cd / && gpr20 verify ~/gpr20_data/2*/"
)
[ $# -eq 0 ] || COMMANDS=("$@")

# make_chroot WHO: one with a clone of HEAD.
make_chroot() {
    local root="$folder/$1" home
    make_root "$1"
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

# run_in_chroot WHO COMMAND LOG: without a locale and anything of the environment of this shell.
run_in_chroot() {
    local root="$folder/$1" home
    home="$(home_of "$1")"
    timeout "$LIMIT_S" bash -c "$(declare -f enter_root)"' && enter_root "$@"' bash "$root" -- \
        env --ignore-environment HOME="$home" USER="$1" PATH=/usr/bin:/bin:/usr/sbin:/sbin \
        "${network[@]}" chroot --userspec="$1:$1" --groups="$1" "$root" \
        bash -c "cd ~/gpr20 && $2" </dev/null >"$3" 2>&1
}

# How pip reaches the network here.
network=(PIP_CERT=/etc/certificates_of_the_host.crt)
for name in http_proxy https_proxy no_proxy; do
    [ -z "${!name:-}" ] || network+=("$name=${!name}")
done

# run_all WHO: run the commands; a line of the table for each.
run_all() {
    local who="$1" number=0 command begin status log
    for command in "${COMMANDS[@]}"; do
        number=$((number + 1))
        log="$folder/$who-$number.log"
        begin="$(date +%s)"
        status=0
        run_in_chroot "$who" "$command" "$log" || status=$?
        printf '%-5s %6d s %6d MB  status %d  %s\n' "$who" $(($(date +%s) - begin)) \
            "$(du -sxm "$folder/$who" | cut -f1)" "$status" "$command"
        if [ "$status" -ne 0 ]; then
            failed=yes
            tail -n 30 "$log" >&2
            return
        fi
    done
}

require_chroot
trap 'rm -rf --one-file-system "$folder/root" "$folder/user"' EXIT
make_base
failed=no
echo "as      time      disk  result    command"
for who in root user; do
    make_chroot "$who"
    run_all "$who"
done
echo "the output of each command is in $folder/*.log"
[ "$failed" = no ]
