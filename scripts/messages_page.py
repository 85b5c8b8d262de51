"""Write docs/messages.md: every sentence of the software in both languages, with what to do.

Started by scripts/translations.sh; with --check it fails if the page is not up to date.
"""

from __future__ import annotations

import re
import string
import sys
import textwrap
from pathlib import Path
from typing import Dict, Iterator, List

import polib
from fault_templates import fault_templates, filled
from value_names import NAMES, shown_name

from gpr20_doctor.mid.remedies import find_remedy

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/messages.md"
CATALOGUE = ROOT / "catkin_ws/src/gpr20_common/src/gpr20_common/translations/es.po"
WIDTH = 98
# Words of a button or a column are no sentence.
FEWEST_BLANKS = 3

SECTIONS = {
    "gpr20_main_control": "Survey",
    "gpr20_axis_driver": "Axes",
    "gpr20_height_sensor": "Height sensor",
    "gpr20_vna_acquisition": "Network analyzer",
    "gpr20_vna_processing": "Storage",
    "gpr20_survey": "Plan, files and traces",
    "gpr20_common": "Connections and nodes",
    "gpr20_doctor": "Doctor",
    "gpr20_launch": "Configuration and launch",
    "gpr20_imaging": "Focused images and export",
    "gpr20_simulator": "Simulated robot",
    "gpr20_visualization": "RViz and other ROS tools",
    "gpr20_user_interface": "Window and terminal",
    "gpr20_analysis": "Offline analysis",
}

INTRODUCTION = """# Messages

Every sentence that the robot, its window and the command `gpr20` can show, in English and Spanish.
Search for words of the message that are no numbers or names: on the site, type them into the field
above; elsewhere, use the search of your reader (Ctrl-F). *First* is what the window's card says to
do first; a message without it says itself what to do, or needs nothing done.

*Todas las frases del robot, de su ventana y de la orden `gpr20`, en inglés y en español. Busque
palabras del mensaje que no sean números ni nombres. «Primero» es lo que la ventana indica hacer
primero.*

{value} stand for a [value](#values). `scripts/messages_page.py` writes this page
from the catalogue of the messages.
"""


def page() -> str:
    """Return the page."""
    catalogue = polib.pofile(str(CATALOGUE))
    spanish = {entry.msgid: entry.msgstr for entry in catalogue}
    faults = set(fault_templates())
    sections: Dict[str, List[str]] = {name: [] for name in SECTIONS}
    for entry in sorted(catalogue, key=lambda one: _sort_key(one.msgid)):
        if entry.msgid.count(" ") < FEWEST_BLANKS:
            continue
        first = find_remedy(filled(entry.msgid)) if entry.msgid in faults else None
        lines = ["**" + _markdown(entry.msgid, "en") + "**", _markdown(entry.msgstr, "es")]
        if first is not None:
            lines.append("*First: " + _markdown(first.template, "en") + "*")
            lines.append("*Primero: " + _markdown(spanish[first.template], "es") + "*")
        sections[_package(entry)].append(_item(lines))
    text = [INTRODUCTION.format(value=_value("Words in these signs"))]
    for package, title in SECTIONS.items():
        text.append(f"## {title}\n\nPackage `{package}`.\n\n" + "\n".join(sections[package]) + "\n")
    return "\n".join([*text, *_values()])


def _values() -> Iterator[str]:
    yield "## Values\n\nThe less obvious ones:\n\n| value | valor | meaning | significado |"
    yield "| --- | --- | --- | --- |"
    for _name, (english, meaning, spanish, significado) in NAMES.items():
        if meaning:
            yield f"| {_value(english)} | {_value(spanish)} | {meaning} | {significado} |"
    yield ""


def _value(name: str) -> str:
    return f"\u2039{name}\u203a"


def _package(entry: polib.POEntry) -> str:
    # The programs of deploy/ belong to the window.
    packages = {
        "gpr20_user_interface" if path.startswith("deploy/") else path.split("/")[2]
        for path, _line in entry.occurrences
    }
    return next(name for name in SECTIONS if name in packages)


def _sort_key(template: str) -> str:
    return re.sub(r"[^a-z ]", "", re.sub(r"\{.*?\}", "", template.lower())).strip()


def _markdown(template: str, language: str) -> str:
    """Return a template as a reader sees it, with its values as words."""
    text = ""
    for words, name, _spec, _conversion in string.Formatter().parse(template):
        text += re.sub(r"([\\*_\[\]<>`#|])", r"\\\1", " ".join(words.split("\n")))
        if name:
            text += _value(shown_name(name, language))
    return text


def _item(lines: List[str]) -> str:
    text: List[str] = []
    for line in lines:
        text += textwrap.wrap(line.strip(), WIDTH - 4, break_on_hyphens=False)
        text[-1] += "<br>"
    text[-1] = text[-1][: -len("<br>")]
    # A wrapped line may not begin a list of its own.
    safe = [text[0]] + [re.sub(r"^([-+]|\d+(?=[.)]))(?= |[.)] )", r"\\\1", one) for one in text[1:]]
    return "- " + "\n  ".join(safe)


if __name__ == "__main__":
    written = page()
    if sys.argv[1:] == ["--check"]:
        if PAGE.read_text(encoding="utf-8") != written:
            sys.exit("docs/messages.md is not up to date; run scripts/translations.sh")
    else:
        PAGE.write_text(written, encoding="utf-8")
