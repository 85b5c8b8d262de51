#!/bin/sh
# The first installation from this bundle, without a network; later ones are made by gpr20-update.
#   sudo sh install.sh gpr20-robot | gpr20-server | gpr20-analysis
# It looks for damage only: whoever can change this file can change the others too. Compare the
# signature before, if the stick was out of your hands (docs/maintain.md).
set -eu
cd "$(dirname "$0")"
case "${1-}" in
    gpr20-robot | gpr20-server | gpr20-analysis) ;;
    *) echo "install.sh: name gpr20-robot, gpr20-server or gpr20-analysis" >&2; exit 2 ;;
esac
# An update has a doctor and a way back; another role would take the services of this one away.
installed="$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' 'gpr20-*' 2>/dev/null |
    sed -n 's/^installed //p' | tr '\n' ' ')"
if [ -n "$installed" ]; then
    echo "install.sh: $installed is installed. Another version: gpr20-update $PWD. Another" \
        "role: first apt-get remove what is there, never during a survey" >&2
    exit 2
fi
sha256sum --check --quiet SHA256SUMS
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial"
# The bundle under a name without spaces, as apt wants it.
ln -s "$PWD" "$work/bundle"
echo "deb [trusted=yes] file:$work/bundle ./" >"$work/sources.list"

bundled_apt() {
    apt-get -q -y --no-install-recommends -o Dir::Etc::sourcelist="$work/sources.list" \
        -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists="$work/lists" \
        -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root "$@"
}

bundled_apt update >/dev/null
bundled_apt install "$1"
# Kept, so that the next update has a way back.
[ ! -x /usr/sbin/gpr20-update ] || gpr20-update . || {
    echo "install.sh: $1 is installed, but the next update has no way back yet" >&2
    exit 1
}
