#!/usr/bin/env bash
# Make the signed bundle of a release: a folder for a USB stick, with the packages that
# scripts/packages.sh has built and every package that they need, so that a bare system of this
# distribution installs and updates without a network (docs/maintain.md).
#   scripts/bundle.sh --key KEY PACKAGES FOLDER   make FOLDER/gpr20-VERSION from the folder PACKAGES
#     KEY   private key; its public line is in deploy/common/etc/gpr20/release_signers
# Needs apt with its usual sources, and the network.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

NAMESPACE=gpr20-release

fail() {
    echo "bundle.sh: $*" >&2
    exit 1
}

key='' places=()
while [ $# -gt 0 ]; do
    case "$1" in
        --key) key="${2:-}"; shift 2 || fail "--key needs a file" ;;
        -*) fail "unknown option '$1'; allowed: --key KEY" ;;
        *) places+=("$(realpath -ms "$1")"); shift ;;
    esac
done
[ ${#places[@]} -eq 2 ] || fail "name the folder of the packages and that of the bundle"
[ -f "$key" ] || fail "name the private key that signs releases: --key KEY"
packages="${places[0]}"
shopt -s nullglob
own=("$packages"/gpr20-*.deb) software=("$packages"/gpr20-software_*.deb)
[ ${#software[@]} -eq 1 ] ||
    fail "$packages has ${#software[@]} packages gpr20-software; it must have those of one version"
version="$(dpkg-deb -f "${software[0]}" Version)"
architecture="$(dpkg-deb -f "${software[0]}" Architecture)"
[ "$architecture" != all ] || architecture="$(dpkg --print-architecture)"
bundle="${places[1]}/gpr20-$version"
[ ! -e "$bundle" ] || fail "$bundle exists; delete it first"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work"/{own,lists/partial,archives/partial}
cp "${own[@]}" "$work/own"
(cd "$work/own" && dpkg-scanpackages --multiversion . >Packages)
# The sources of this machine, and the packages themselves.
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

echo "collecting what the packages of version $version need"
apt update
# One after the other: some of them exclude each other.
for one in "${own[@]}"; do
    apt install --download-only "$(dpkg-deb -f "$one" Package)=$version" >/dev/null
done

mkdir -p "$bundle"
cp "${own[@]}" "$bundle"
for one in "$work"/archives/*.deb; do
    # Without the epoch, whose %3a some file systems and programs change.
    name="$(basename "$one")"
    cp "$one" "$bundle/$(sed 's/_[0-9]*%3a/_/' <<<"$name")"
done
cp "$GPR20_ROOT/deploy/bundle_install.sh" "$bundle/install.sh"
(
    cd "$bundle"
    dpkg-scanpackages --multiversion . >Packages
    sha256sum -- * >SHA256SUMS
)
ssh-keygen -Y sign -f "$key" -n "$NAMESPACE" "$bundle/SHA256SUMS" ||
    fail "the bundle could not be signed with $key"
echo "$bundle: $(find "$bundle" -name '*.deb' | wc -l) packages, $(du -sh "$bundle" | cut -f1)"
