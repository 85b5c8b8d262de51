"""Write docs/reference/messages.md: faults by their code, with what to do first, in two languages.

Started by scripts/translations.sh; with --check it fails if the page is not up to date.
"""

from __future__ import annotations

import importlib
import itertools
import re
import sys
import textwrap
from pathlib import Path
from typing import Dict, Iterator, List, Mapping

import polib

from gpr20_common.message import Fault, Severity

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/reference/messages.md"
CATALOGUE = ROOT / "catkin_ws/src/gpr20_common/src/gpr20_common/translations/es.po"
WIDTH = 94

INTRODUCTION = """# Messages

All faults by their code, with what to do first in English and Spanish. A code has the form
`area.what` and stays when a sentence is reworded. It is behind DETAILS of the window's card, in the
outputs `--json`, and in `fault_code` of services, topics and survey.json.

*Todos los fallos por su código, con lo primero que se debe hacer, en inglés y en español. El código
está en los detalles de la tarjeta de la ventana.*

`tools/pages/messages_page.py` writes this page from the modules `faults` of the packages. Areas:
"""

REMARKS = {Severity.NOTE: "note", Severity.WARNING: "warning"}


def all_faults() -> List[Fault]:
    """Return the faults of all packages, in the order of their codes.

    Raises:
        ValueError: Two faults have one code.
    """
    faults: Dict[str, Fault] = {}
    for path in sorted(ROOT.glob("catkin_ws/src/gpr20_*/src/*/faults.py")):
        module = importlib.import_module(f"{path.parent.name}.faults")
        for one in vars(module).values():
            if isinstance(one, Fault) and faults.setdefault(one.code, one) != one:
                raise ValueError(f"two faults have the code {one.code}")
    return [faults[code] for code in sorted(faults)]


def page() -> str:
    """Return the page."""
    spanish = {entry.msgid: entry.msgstr for entry in polib.pofile(str(CATALOGUE))}
    faults = all_faults()
    areas = dict.fromkeys(_area(fault) for fault in faults)
    links = ", ".join(f"[{area}](#{area})" for area in areas) + "."
    text = [INTRODUCTION.rstrip(), *textwrap.wrap(links, WIDTH), ""]
    for area, members in itertools.groupby(faults, key=_area):
        text.append(f"## {area}\n")
        text += [line for fault in members for line in _item(fault, spanish)]
        text.append("")
    return "\n".join(text)


def _area(fault: Fault) -> str:
    return fault.code.split(".")[0]


def _item(fault: Fault, spanish: Mapping[str, str]) -> Iterator[str]:
    remarks = [REMARKS[fault.severity]] if fault.severity in REMARKS else []
    if fault.may_move:
        remarks.append("something may still move")
    if not fault.can_continue:
        remarks.append("the survey cannot continue")
    lines = [f"`{fault.code}`" + (f" ({', '.join(remarks)})" if remarks else "")]
    if fault.remedy is not None:
        template = fault.remedy.template
        lines += [_markdown(template), f"*{_markdown(spanish[template])}*"]
    wrapped: List[str] = []
    for line in lines:
        wrapped += textwrap.wrap(line, WIDTH, break_on_hyphens=False)
        wrapped[-1] += "<br>"
    wrapped[-1] = wrapped[-1][: -len("<br>")]
    yield "- " + wrapped[0]
    yield from (f"  {line}" for line in wrapped[1:])


def _markdown(text: str) -> str:
    return re.sub(r"([\\*_\[\]<>`#|])", r"\\\1", " ".join(text.split()))


if __name__ == "__main__":
    written = page()
    if sys.argv[1:] == ["--check"]:
        if PAGE.read_text(encoding="utf-8") != written:
            sys.exit("docs/reference/messages.md is not up to date; run scripts/translations.sh")
    else:
        PAGE.write_text(written, encoding="utf-8")
