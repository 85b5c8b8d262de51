#!/usr/bin/env bash
# Make a folder, such as that of a USB stick, a signed repository of apt with the package that
# scripts/package.sh has built and every package that it needs, so that a bare system of this
# distribution installs and updates without a network (docs/maintain.md). What the folder has
# already, for example for another architecture, stays.
#   scripts/stick.sh --key KEY PACKAGE FOLDER
#     KEY       name of the key in gpg that signs releases
#     PACKAGE   the file gpr20_VERSION_ARCHITECTURE.deb
# Needs apt with its usual sources, gpg and the network.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

fail() {
    echo "stick.sh: $*" >&2
    exit 1
}

key='' places=()
while [ $# -gt 0 ]; do
    case "$1" in
        --key) key="${2:-}"; shift 2 || fail "--key needs a name" ;;
        -*) fail "unknown option '$1'; allowed: --key KEY" ;;
        *) places+=("$(realpath -ms "$1")"); shift ;;
    esac
done
[ ${#places[@]} -eq 2 ] && [ -f "${places[0]}" ] ||
    fail "name the package and the folder of the stick"
[ -n "$key" ] || fail "name the key that signs releases: --key KEY"
package="${places[0]}"
version="$(dpkg-deb -f "$package" Version)"
architecture="$(dpkg-deb -f "$package" Architecture)"
[ "$architecture" != all ] || architecture="$(dpkg --print-architecture)"
stick="${places[1]}"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work"/{own,lists/partial,archives/partial}
cp "$package" "$work/own"
(cd "$work/own" && dpkg-scanpackages --multiversion . >Packages)
# The sources of this machine, and the package itself.
cp -r /etc/apt/sources.list.d "$work/parts"
echo "deb [trusted=yes] file:$work/own ./" >"$work/parts/gpr20_own.list"
# Nothing is installed in the eyes of this apt, so that it fetches everything.
: >"$work/status"

apt() {
    apt-get --quiet=2 --yes --no-install-recommends \
        -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
        -o APT::Sandbox::User=root -o Dir::State::status="$work/status" \
        -o Dir::State::lists="$work/lists" -o Dir::Cache::archives="$work/archives" \
        -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= \
        -o Dir::Etc::sourceparts="$work/parts" -o Debug::NoLocking=true "$@"
}

echo "collecting what version $version needs"
apt update
# Only what the package itself recommends, not what others do.
recommended="$(dpkg-deb -f "$package" Recommends | tr -d ,)"
# shellcheck disable=SC2086
apt install --download-only "gpr20=$version" $recommended >/dev/null

mkdir -p "$stick"
cp "$package" "$stick"
for one in "$work"/archives/*.deb; do
    # Without the epoch, whose %3a some file systems and programs change.
    name="$(basename "$one")"
    cp "$one" "$stick/$(sed 's/_[0-9]*%3a/_/' <<<"$name")"
done
cp "$GPR20_ROOT/deploy/install.sh" "$stick/install.sh"
cd "$stick"
dpkg-scanpackages --multiversion . >Packages
# apt looks for it under the name Packages, and compares size and sum.
cat >Release <<END
Origin: GPR-20
Date: $(LC_ALL=C date -u '+%a, %d %b %Y %H:%M:%S UTC')
SHA256:
 $(sha256sum <Packages | cut -d ' ' -f 1) $(stat -c %s Packages) Packages
END
gpg --quiet --yes --local-user "$key" --clearsign --output InRelease Release ||
    fail "the stick could not be signed with the key $key"
gpg --quiet --armor --export "$key" >release_key.asc
rm Release
echo "$stick: $(find . -name '*.deb' | wc -l) packages, $(du -sh . | cut -f1)"
