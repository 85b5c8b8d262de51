#!/usr/bin/env bash
# Release the commit that is checked out: version, changelog, commit and tag. Nothing is pushed.
#   scripts/release.sh [--dry-run] [--no-tests] VERSION|major|minor|patch
#     --dry-run    change nothing; say what would change
#     --no-tests   do not run the tests first: they have passed for this commit
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"

fail() {
    echo "release.sh: $*" >&2
    exit 1
}

dry_run=no tests=yes wanted=""
for argument in "$@"; do
    case "$argument" in
        --dry-run) dry_run=yes ;;
        --no-tests) tests=no ;;
        major | minor | patch) wanted="$argument" ;;
        *)
            [[ "$argument" =~ ^[0-9]+\.[0-9]+\.[0-9]+$ ]] ||
                fail "unknown argument '$argument'; allowed: --dry-run, --no-tests," \
                    "and major, minor, patch or a version such as 1.2.3"
            wanted="$argument" ;;
    esac
done
[ -n "$wanted" ] || fail "which version? major, minor, patch or a version such as 1.2.3"

bump="$GPR20_VENV/bin/bump-my-version"
[ -x "$bump" ] || fail "$bump is missing; run scripts/setup.sh --dev"
current="$("$bump" show current_version)"
case "$wanted" in
    major | minor | patch)
        arguments=("$wanted")
        new="$("$bump" show --increment "$wanted" new_version)" ;;
    *)
        arguments=(--new-version "$wanted")
        new="$wanted" ;;
esac
newest="$(printf '%s\n' "$current" "$new" | sort -V | tail -n 1)"
[ "$new" != "$current" ] && [ "$new" = "$newest" ] || fail "$new is not after $current"

branch="$(git branch --show-current)"
[ "$branch" = main ] || fail "this is branch '$branch'; check out main"
[ -z "$(git status --porcelain)" ] || fail "commit or remove your changes (git status) first"
if git rev-parse --quiet --verify "refs/tags/$new" >/dev/null; then fail "tag $new exists"; fi
# Of its section of the changelog, the first entry.
awk '/^Forthcoming$/ { inside = 1 } /^[0-9]+\.[0-9]+\.[0-9]+ / { exit } inside && /^[-*] /' \
    catkin_ws/src/gpr20/CHANGELOG.rst | grep -q . ||
    fail "catkin_ws/src/gpr20/CHANGELOG.rst has no entry under 'Forthcoming'"
grep -q '^repository-code:' CITATION.cff ||
    echo "release.sh: CITATION.cff names no address of the project: packages have no <url>" >&2

if [ "$dry_run" = yes ]; then
    "$bump" bump "${arguments[@]}" --dry-run -vv 2>&1 |
        sed -nE 's/.*--- after ([^ :]+).*/would change \1/p' | sort -u
    echo "would commit and tag this as $new (was $current)"
    exit
fi
if [ "$tests" = yes ]; then
    scripts/test.sh && scripts/test.sh release && scripts/test.sh random unit commands
fi
"$bump" bump "${arguments[@]}"
echo "$new is committed and tagged. To publish it: git push origin main $new"
