#!/usr/bin/env bash
# The catalogue of every sentence that people read, kept with GNU gettext.
#   scripts/translations.sh           update es.po: new templates have an empty msgstr; run it
#                                     again after writing them, for the page of the messages
#   scripts/translations.sh --check   fail on a template without Spanish, or the reverse, or if
#                                     docs/messages.md is not up to date
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$GPR20_ROOT"

catalogue=catkin_ws/src/gpr20_common/src/gpr20_common/translations/es.po
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT

# docs/messages.md, from the catalogue.
messages_page() {
    PYTHONPATH="$(printf '%s:' "$GPR20_WORKSPACE"/src/gpr20_*/src)" \
        "$GPR20_VENV/bin/python" scripts/messages_page.py "$@"
}

mapfile -d '' -t sources < <(git ls-files --cached --others --exclude-standard -z \
    'catkin_ws/src/*/src/*.py' 'catkin_ws/src/*/nodes/*' 'deploy/*.py')
/usr/bin/python3 scripts/literal_templates.py "${sources[@]}"

# Templates are the first argument of Message(...) and of tr(...).
xgettext --language=Python --from-code=UTF-8 --keyword --keyword=Message:1 --keyword=tr:1 \
    --add-location=file --sort-by-file --width=98 --output="$scratch/templates.pot" "${sources[@]}"
# msgcmp and msgmerge want the charset that xgettext leaves open where every template is ASCII.
sed -i 's/charset=CHARSET/charset=UTF-8/' "$scratch/templates.pot"

if [ "${1:-}" = --check ]; then
    if ! msgfmt --check-format --output-file=/dev/null "$catalogue"; then
        echo "translations.sh: $catalogue: give each msgstr the {values} of its msgid" >&2
        exit 1
    fi
    # Unlike msgcmp's warnings, an entry that no template has is an error here.
    if ! msgcmp "$catalogue" "$scratch/templates.pot" 2>"$scratch/complaints" ||
        [ -s "$scratch/complaints" ]; then
        cat "$scratch/complaints" >&2
        echo "translations.sh: the sources and $catalogue differ; run scripts/translations.sh," \
            "then write the msgstr of each entry that has none or is marked fuzzy" >&2
        exit 1
    fi
    messages_page --check
else
    msgmerge --quiet --no-fuzzy-matching --add-location=file --sort-by-file --width=98 \
        --output-file="$scratch/merged.po" "$catalogue" "$scratch/templates.pot"
    # Without the date of the templates: a catalogue that says the same is the same file.
    msgattrib --no-obsolete --width=98 "$scratch/merged.po" |
        sed '/^"\(POT-Creation-Date\|Report-Msgid-Bugs-To\):/d' >"$catalogue"
    msgfmt --statistics --output-file=/dev/null "$catalogue"
    messages_page
fi
