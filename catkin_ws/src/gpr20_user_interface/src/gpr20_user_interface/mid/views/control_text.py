"""The standard sentences of main_control and of the coverage in the operator's language."""

from __future__ import annotations

import re

from PyQt5.QtCore import QCoreApplication

_COMPLETE = re.compile(r"complete: all (?P<planned>\d+) planned traces are stored")
_INCOMPLETE = re.compile(
    r"INCOMPLETE: (?P<stored>\d+) of (?P<planned>\d+) planned traces are stored, "
    r"(?P<failed>\d+) failed, (?P<missing>\d+) not visited"
)


def control_text(text: str) -> str:
    """Return a sentence in the language of the application; one that is not known as it is.

    Only whole sentences are translated: half a reason in another language could be misread.
    """
    translate = QCoreApplication.translate
    complete = _COMPLETE.fullmatch(text)
    if complete:
        return translate("ControlText", "complete: all {planned} planned traces are stored").format(
            **complete.groupdict()
        )
    incomplete = _INCOMPLETE.fullmatch(text)
    if incomplete:
        return translate(
            "ControlText",
            "INCOMPLETE: {stored} of {planned} planned traces are stored, "
            "{failed} failed, {missing} not visited",
        ).format(**incomplete.groupdict())
    return {
        "measuring": translate("ControlText", "measuring"),
        "homing the axes": translate("ControlText", "homing the axes"),
        "checking the robot": translate("ControlText", "checking the robot"),
        "checking the robot before going on": translate(
            "ControlText", "checking the robot before going on"
        ),
        "pausing after this sample": translate("ControlText", "pausing after this sample"),
    }.get(text, text)
