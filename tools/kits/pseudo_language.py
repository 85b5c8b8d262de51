"""A language that nobody speaks, for the tests: every template with accents, as long as Spanish."""

from __future__ import annotations

import re
from pathlib import Path

import polib

from gpr20_common.catalogue import FOLDER, Language

PSEUDO = Language("qps", "Þšéûðö")
ACCENTS = str.maketrans("aeioucnszAEIOUCN", "àéîöüçñšžÀÉÎÖÜÇÑ")
# The values in braces stay as they are, and so do the marks of a text.
PARTS = re.compile(r"(\{[^{}]*\}|<[^<>]*>|&\w+;|%\w)")


def write_pseudo_catalogue(folder: Path, leave_out: str = "") -> Path:
    """Write its catalogue into a folder.

    Args:
        folder: Where to.
        leave_out: A template that it does not translate.
    """
    catalogue = polib.POFile()
    catalogue.metadata = {
        "Language": PSEUDO.value,
        "X-Language-Name": PSEUDO.own_name,
        "Content-Type": "text/plain; charset=UTF-8",
    }
    for entry in polib.pofile(str(FOLDER / "es.po")):
        if entry.msgid != leave_out:
            catalogue.append(polib.POEntry(msgid=entry.msgid, msgstr=pseudo(entry)))
    path = folder / f"{PSEUDO.value}.po"
    catalogue.save(str(path))
    return path


def pseudo(entry: polib.POEntry) -> str:
    """Return the template of an entry with accents, and with more letters, as long as Spanish."""
    lines = entry.msgid.split("\n")
    spanish = entry.msgstr.split("\n")
    if len(spanish) != len(lines):
        spanish = lines
    return "\n".join(_longer(line, len(other)) for line, other in zip(lines, spanish))


def _longer(line: str, length: int) -> str:
    parts = PARTS.split(line)
    parts[::2] = [part.translate(ACCENTS) for part in parts[::2]]
    accented = "".join(parts)
    more = max(0, length - len(accented))
    # In words, as in any language: a line can break between them.
    return accented + "".join(" " if one % 8 == 0 else "é" for one in range(more))
