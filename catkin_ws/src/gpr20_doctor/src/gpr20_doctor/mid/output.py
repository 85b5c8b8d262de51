"""Findings as text and as JSON."""

from __future__ import annotations

import json
from typing import Any, Dict, Iterator, Tuple

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import exit_status, summary

BETWEEN = "; "
LEVEL_WIDTH = 12


def lines(found: Tuple[Finding, ...], catalogue: Catalogue) -> Iterator[str]:
    """Yield the lines of a terminal: level and sentence, the remedy below, counts at the end."""
    for one in found:
        level = catalogue.text(one.level.title)
        yield f"{level:{LEVEL_WIDTH}}{_with_details(one.text, catalogue)}"
        if one.remedy is not None:
            yield f"{'':{LEVEL_WIDTH}}-> {catalogue.text(one.remedy)}"
    yield catalogue.text(summary(found))


def as_json(found: Tuple[Finding, ...], catalogue: Catalogue) -> str:
    """Return findings as one JSON object."""
    record: Dict[str, Any] = {
        "status": exit_status(found),
        "findings": [
            {
                "check": one.check,
                "fault_code": one.text.fault_code,
                "level": one.level.name,
                "text": catalogue.text(one.text),
                "details": BETWEEN.join(one.text.all_details),
                "remedy": "" if one.remedy is None else catalogue.text(one.remedy),
            }
            for one in found
        ],
    }
    return json.dumps(record, indent=2)


def _with_details(message: Message, catalogue: Catalogue) -> str:
    details = BETWEEN.join(message.all_details)
    text = catalogue.text(message)
    return f"{text} ({details})" if details else text
