"""The page of the messages: every fault by its code, with what to do first, in two languages."""

from __future__ import annotations

import importlib
import itertools
import re
from pathlib import Path
from typing import Iterator, List

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.message import Fault, Severity

ROOT = Path(__file__).resolve().parents[2]


def messages_markdown() -> str:
    """Return what the site adds to docs/reference/messages.md: a heading for each area."""
    spanish, area, parts = read_catalogue(Language.SPANISH), "", []
    for code, same in itertools.groupby(all_faults(), key=lambda one: one.code):
        if code.split(".")[0] != area:
            area = code.split(".")[0]
            parts.append(f"\n## {area}\n")
        parts.append("- " + "<br>\n  ".join(_lines([*same], spanish)))
    return "\n".join(parts) + "\n"


def all_faults() -> List[Fault]:
    """Return the faults of all packages, in the order of their codes."""
    found = []
    for path in sorted(ROOT.glob("catkin_ws/src/gpr20_*/src/*/faults.py")):
        module = importlib.import_module(f"{path.parent.name}.faults")
        found += [one for one in vars(module).values() if isinstance(one, Fault)]
    return sorted(found, key=lambda one: one.code)


def _lines(same: List[Fault], spanish: Catalogue) -> Iterator[str]:
    """Yield what holds for all faults of one code."""
    severities = {one.severity for one in same}
    remarks = [one.value for one in severities - {Severity.FAULT} if len(severities) == 1]
    remarks += ["something may still move"] * all(one.may_move for one in same)
    remarks += ["the survey cannot continue"] * (not any(one.can_continue for one in same))
    yield f"`{same[0].code}`" + (f" ({', '.join(remarks)})" if remarks else "")
    (remedy,) = {one.remedy for one in same}
    if remedy is not None:
        # Remedies that only analysts read are English.
        template = spanish.template(remedy.template)
        yield _markdown(remedy.template)
        if template != remedy.template:
            yield f"*{_markdown(template)}*"


def _markdown(text: str) -> str:
    return re.sub(r"([\\*_\[\]<>`#|])", r"\\\1", " ".join(text.split()))
