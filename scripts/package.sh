#!/usr/bin/env bash
# Build the Debian package of a commit, by default of the one that is checked out (debian/,
# docs/install.md). Its version is the tag, or that of the last release with date and commit.
#   scripts/package.sh FOLDER [COMMIT]   put the package into FOLDER (about 5 min)
# Needs the network for Python packages, and what `scripts/setup.sh --dev` installs.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

fail() {
    echo "package.sh: $*" >&2
    exit 1
}

case "${1-}" in '' | -*) fail "name a folder for the package, and perhaps a commit" ;; esac
folder="$(realpath -ms "$1")" commit="${2-HEAD}"
command -v dh >/dev/null || fail "debhelper is missing; run scripts/setup.sh --dev"

build="$(mktemp -d)"
trap 'rm -rf "$build"' EXIT
git clone --quiet "$GPR20_ROOT" "$build/gpr20"
cd "$build/gpr20"
revision="$(git -C "$GPR20_ROOT" rev-parse --verify --quiet "$commit^{commit}")" ||
    fail "'$commit' is no commit or tag"
git checkout --quiet "$revision"

# As the packages of the workspace have it.
released="$(sed -n "s:.*<version>\(.*\)</version>.*:\1:p" catkin_ws/src/gpr20/package.xml)"
version="$(git describe --tags --exact-match 2>/dev/null)" ||
    version="$released+git$(git show -s --format=%cd --date=format:%Y%m%d%H%M).$(
        git rev-parse --short HEAD)"
cat >debian/changelog <<END
gpr20 ($version) stable; urgency=medium

  * What is new is in catkin_ws/src/gpr20/CHANGELOG.rst.

 -- GPR-20 developers <maintainers@gpr20.example>  $(git show -s --format=%cD)
END
echo "building the package $version (about 5 min)"
if ! dpkg-buildpackage --build=binary --no-sign --no-check-builddeps >"$build/log" 2>&1; then
    tail -n 30 "$build/log" >&2
    fail "the build failed; the lines above say where"
fi
mkdir -p "$folder"
mv "$build"/*.deb "$folder"
ls -sh1 "$folder"/*.deb
