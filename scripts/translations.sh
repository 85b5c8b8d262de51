#!/usr/bin/env bash
# The catalogues of every sentence that people read, kept with GNU gettext.
#   scripts/translations.sh                     update each: new templates have an empty msgstr and
#                                               are listed with FILE:LINE; run it again after
#                                               writing them, for docs/reference/messages.md
#   scripts/translations.sh --check             fail on a template without Spanish, on an entry that
#                                               has no template or other {values} than it, or if
#                                               docs/reference/messages.md is not up to date
#   scripts/translations.sh --new FILE.po NAME  begin a catalogue; FILE is the code of its language
#   scripts/translations.sh FILE.po             update a catalogue of another folder
#   scripts/translations.sh --check FILE.po     check it; entries may be missing
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

mode=update
case "${1:-}" in --check) mode=check; shift ;; --new) mode=new; shift ;; esac
given="${1:+$(realpath -m "$1")}"
name="${2:-}"
cd "$GPR20_ROOT"
folder=catkin_ws/src/gpr20_common/src/gpr20_common/translations
# The project translates everything into this language; others may have gaps, which are English.
complete=$folder/es.po
code="$(basename "$given" .po)"
if [ "$mode" = new ] && { [ -e "$given" ] || [ -z "$name" ] ||
    ! [[ "$code" =~ ^[a-z]{2,3}(_[A-Z]{2})?$ ]]; }; then
    echo "translations.sh: name a new file and its language: --new pt.po Português" >&2
    exit 1
fi
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT

# docs/reference/messages.md, from the catalogue.
messages_page() {
    PYTHONPATH="$(printf '%s:' "$GPR20_WORKSPACE"/src/gpr20_*/src)" \
        "$GPR20_VENV/bin/python" tools/pages/messages_page.py "$@"
}

mapfile -d '' -t sources < <(git ls-files --cached --others --exclude-standard -z \
    'catkin_ws/src/*/src/*.py' 'catkin_ws/src/*/nodes/*' 'deploy/*.py')
/usr/bin/python3 tools/checks/literal_templates.py "${sources[@]}"

# Templates are the first argument of Message(...) and of tr(...).
xgettext --language=Python --from-code=UTF-8 --keyword --keyword=Message:1 --keyword=tr:1 \
    --add-location=file --sort-by-file --width=98 --output="$scratch/templates.pot" "${sources[@]}"
# msgcmp and msgmerge want the charset that xgettext leaves open where every template is ASCII.
sed -i 's/charset=CHARSET/charset=UTF-8/' "$scratch/templates.pot"

check() {
    local catalogue="$1" gaps=()
    if ! msgfmt --check-format --output-file=/dev/null "$catalogue"; then
        echo "translations.sh: $catalogue: give each msgstr the {values} of its msgid" >&2
        exit 1
    fi
    [ "$catalogue" = "$complete" ] || gaps=(--use-untranslated)
    # Unlike msgcmp's warnings, an entry that no template has is an error here.
    if ! msgcmp "${gaps[@]}" "$catalogue" "$scratch/templates.pot" 2>"$scratch/complaints" ||
        [ -s "$scratch/complaints" ]; then
        cat "$scratch/complaints" >&2
        echo "translations.sh: the sources and $catalogue differ; run scripts/translations.sh," \
            "then write the msgstr of each entry that has none or is marked fuzzy" >&2
        exit 1
    fi
}

# Where an msgstr is to be written, as FILE:LINE and its template.
lines_to_write() {
    local catalogue="$1"
    "$GPR20_VENV/bin/python" - "$catalogue" <<'END'
import sys
import polib
for entry in polib.pofile(sys.argv[1]).untranslated_entries():
    print(f"write the msgstr of {sys.argv[1]}:{entry.linenum}: {entry.msgid}", file=sys.stderr)
END
}

update() {
    local catalogue="$1"
    msgmerge --quiet --no-fuzzy-matching --add-location=file --sort-by-file --width=98 \
        --output-file="$scratch/merged.po" "$catalogue" "$scratch/templates.pot"
    # Without the date of the templates: a catalogue that says the same is the same file.
    msgattrib --no-obsolete --width=98 "$scratch/merged.po" |
        sed '/^"\(POT-Creation-Date\|Report-Msgid-Bugs-To\):/d' >"$catalogue"
    msgfmt --statistics --output-file=/dev/null "$catalogue"
    # Only the complete catalogue must have every msgstr: say where one is missing.
    [ "$catalogue" != "$complete" ] || lines_to_write "$catalogue"
}

begin() {
    local catalogue="$1"
    mkdir -p "$(dirname "$catalogue")"
    printf 'msgid ""\nmsgstr ""\n' >"$catalogue"
    printf '"%s\\n"\n' "Project-Id-Version: gpr20" "Language: $code" "X-Language-Name: $name" \
        "MIME-Version: 1.0" "Content-Type: text/plain; charset=UTF-8" \
        "Content-Transfer-Encoding: 8bit" >>"$catalogue"
    update "$catalogue"
}

catalogues=("$folder"/*.po)
[ -z "$given" ] || catalogues=("$given")
for catalogue in "${catalogues[@]}"; do
    case "$mode" in
    check) check "$catalogue" ;;
    new) begin "$catalogue" ;;
    update) update "$catalogue" ;;
    esac
done
# The page is about the project's own catalogue.
if [ -z "$given" ]; then
    case "$mode" in
    check) messages_page --check ;;
    update) messages_page ;;
    esac
fi
