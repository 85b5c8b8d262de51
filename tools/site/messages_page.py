"""The page of the messages: every fault by its code, with what to do first, in two languages."""

from __future__ import annotations

import importlib
import itertools
import re
from pathlib import Path
from typing import Dict, Iterator, List

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.message import Fault, Severity

ROOT = Path(__file__).resolve().parents[2]


def messages_markdown() -> str:
    """Return what the site adds to docs/reference/messages.md: a heading for each area."""
    spanish = read_catalogue(Language.SPANISH)
    parts: List[str] = []
    for area, faults in itertools.groupby(all_faults(), key=lambda one: one.code.split(".")[0]):
        parts.append(f"\n## {area}\n")
        parts += ["- " + "<br>\n  ".join(_lines(one, spanish)) for one in faults]
    return "\n".join(parts) + "\n"


def all_faults() -> List[Fault]:
    """Return the faults of all packages, one of each code, in their order.

    Raises:
        ValueError: One code has two remedies.
    """
    faults: Dict[str, Fault] = {}
    for path in sorted(ROOT.glob("catkin_ws/src/gpr20_*/src/*/faults.py")):
        module = importlib.import_module(f"{path.parent.name}.faults")
        for one in vars(module).values():
            if not isinstance(one, Fault):
                continue
            known = faults.setdefault(one.code, one)
            if known.remedy != one.remedy:
                raise ValueError(f"the code {one.code} has two remedies")
            if known != one:  # what is said of the code holds for all its faults
                moves = known.may_move and one.may_move
                goes_on = known.can_continue or one.can_continue
                faults[one.code] = Fault(one.code, one.remedy, may_move=moves, can_continue=goes_on)
    return [faults[code] for code in sorted(faults)]


def _lines(fault: Fault, spanish: Catalogue) -> Iterator[str]:
    remarks = [] if fault.severity is Severity.FAULT else [fault.severity.value]
    remarks += ["something may still move"] * fault.may_move
    remarks += ["the survey cannot continue"] * (not fault.can_continue)
    yield f"`{fault.code}`" + (f" ({', '.join(remarks)})" if remarks else "")
    if fault.remedy is not None:
        # Remedies that only analysts read are English.
        english, template = fault.remedy.template, spanish.template(fault.remedy.template)
        yield _markdown(english)
        if template != english:
            yield f"*{_markdown(template)}*"


def _markdown(text: str) -> str:
    return re.sub(r"([\\*_\[\]<>`#|])", r"\\\1", " ".join(text.split()))
