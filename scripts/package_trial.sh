#!/usr/bin/env bash
# For maintainers: install, upgrade, downgrade, remove and purge the packages in a bare Debian 12
# that has no network, from two bundles (scripts/bundle.sh), and look at what is left.
#   sudo scripts/package_trial.sh OLD NEW   gpr20-robot, gpr20-server and gpr20-analysis, each in a
#                                           chroot of its own
# Status 0 if everything was as expected. The chroots are in the folder of steps/chroot.sh.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
# shellcheck source=scripts/steps/chroot.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/chroot.sh"

for bundle in "${1-}" "${2-}"; do
    if [ ! -f "$bundle/Packages" ]; then
        echo "package_trial.sh: '$bundle' is no bundle with a file Packages; make two with" \
            "scripts/bundle.sh and name their folders" >&2
        exit 2
    fi
done
old="$(realpath "$1")" new="$(realpath "$2")"

require_chroot
make_base
failed=no
for package in gpr20-robot gpr20-server gpr20-analysis; do
    root="$folder/trial" log="$folder/$package.log" status=0
    make_root trial
    mkdir "$root/old" "$root/new"
    cp "$GPR20_ROOT/scripts/steps/package_trial_steps.sh" "$root/root/steps.sh"
    begin="$(date +%s)"
    enter_root "$root" --net -- bash -ec 'mount --bind "$2" "$1/old"
        mount --bind "$3" "$1/new"
        ip link set lo up
        env --ignore-environment HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin \
            chroot "$1" bash /root/steps.sh "$4"' \
        bash "$root" "$old" "$new" "$package" >"$log" 2>&1 || status=$?
    grep '^== ' "$log" || true
    echo "$package: $([ "$status" -eq 0 ] && echo passed || echo "status $status")," \
        "$(($(date +%s) - begin)) s; the log is $log"
    if [ "$status" -ne 0 ]; then
        failed=yes
        tail -n 20 "$log" >&2
    fi
    rm -rf --one-file-system "$root"
done
[ "$failed" = no ]
