#!/bin/sh
# The first installation from this stick, without a network; later ones are made by gpr20-update.
#   sudo sh install.sh [--no-install-recommends]     without X, for a computer without the window
# The key of the robot, if it has none yet, becomes the one of this stick: compare its fingerprint
# before (docs/maintain.md).
set -eu
cd "$(dirname "$0")"
if dpkg-query -W -f '${db:Status-Status}\n' gpr20 2>/dev/null | grep -qx installed; then
    # It has a doctor and a way back.
    echo "install.sh: gpr20 is installed. For another version: gpr20-update $PWD" >&2
    exit 2
fi
key=/etc/gpr20/release_key.asc
mkdir -p /etc/gpr20
[ -e "$key" ] || cp release_key.asc "$key"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial"
# Under a name without spaces, as apt wants it.
ln -s "$PWD" "$work/stick"
echo "deb [signed-by=$key] file:$work/stick ./" >"$work/sources.list"

stick_apt() {
    apt-get -q -y -o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o Dir::State::lists="$work/lists" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= \
        -o APT::Sandbox::User=root -o Acquire::Check-Date=false "$@"
}

stick_apt update >/dev/null
stick_apt install gpr20 "$@"
# Kept, so that the next update has a way back.
gpr20-update .
