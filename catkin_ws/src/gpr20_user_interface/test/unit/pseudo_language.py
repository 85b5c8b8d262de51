"""A language that nobody speaks, for the tests: every template with accents."""

from __future__ import annotations

import re

import polib

from gpr20_common.catalogue import FOLDER, Language

PSEUDO = Language("qps", "Þšéûðö")
ACCENTS = str.maketrans("aeioucnszAEIOUCN", "àéîöüçñšžÀÉÎÖÜÇÑ")
# The values in braces stay as they are, and so do the marks of a text.
PARTS = re.compile(r"(\{[^{}]*\}|<[^<>]*>|&\w+;|%\w)")


def write_pseudo_catalogue(folder, leave_out):
    """Write its catalogue into a folder; it does not translate one template."""
    catalogue = polib.POFile()
    catalogue.metadata = {
        "Language": PSEUDO.value,
        "X-Language-Name": PSEUDO.own_name,
        "Content-Type": "text/plain; charset=UTF-8",
    }
    for entry in polib.pofile(str(FOLDER / "es.po")):
        if entry.msgid != leave_out:
            parts = PARTS.split(entry.msgid)
            parts[::2] = [one.translate(ACCENTS) for one in parts[::2]]
            catalogue.append(polib.POEntry(msgid=entry.msgid, msgstr="".join(parts)))
    catalogue.save(str(folder / f"{PSEUDO.value}.po"))
