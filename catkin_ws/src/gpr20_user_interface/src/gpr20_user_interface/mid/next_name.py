"""The name that is proposed for the next survey."""

from __future__ import annotations

import re

from gpr20_survey.plan.annotation import MAX_NAME_CHARACTERS

_NUMBER_AT_END = re.compile(r"([0-9]{1,9})$", re.ASCII)


def first_name(site: str) -> str:
    """Return the name of the first survey at a site; empty if the site has no name."""
    return _joined(site.strip(), " 1") if site.strip() else ""


def next_name(name: str) -> str:
    """Return the name of the survey after one: "El Carmen 3" follows "El Carmen 2".

    The number keeps its leading zeros. A name without a number gets a 2; no name stays none.
    """
    if not name:
        return ""
    found = _NUMBER_AT_END.search(name)
    if found is None:
        return _joined(name, " 2")
    digits = found.group(1)
    return _joined(name[: found.start()], str(int(digits) + 1).zfill(len(digits)))


def _joined(before: str, after: str) -> str:
    return before[: MAX_NAME_CHARACTERS - len(after)] + after
