"""Which analyzers a survey is measured with."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence

from gpr20_common.message import Message
from gpr20_main_control.errors import OtherAnalyzerError, SurveyError
from gpr20_survey.trace.utc_time import iso_text

# Place of the serial number in an identity: maker, model, serial number, firmware.
SERIAL_NUMBER = 2
# The entry of the report that lists the analyzers.
ANALYZERS = "analyzers"


@dataclass(frozen=True)
class UsedAnalyzer:
    """An analyzer of a survey.

    Attributes:
        identity: What the instrument says it is.
        from_index: Index of the first point that was measured with it.
        accepted: When the survey began with it, ISO 8601; None if not recorded.
    """

    identity: str
    from_index: int
    accepted: Optional[str]


class AnalyzerRecord:
    """The analyzers of one survey. Another one is used only if the operator accepts it.

    Attributes:
        accept: Identity of the analyzer that the operator accepts at the next check; empty if
            none. Each check ends it.
        checked: Set when an analyzer was checked and may be used.
    """

    def __init__(self, used: Sequence[UsedAnalyzer]) -> None:
        """Begin, or continue, a record."""
        self.accept = ""
        self.checked = threading.Event()
        self._used = list(used)

    @property
    def used(self) -> List[UsedAnalyzer]:
        """The analyzers so far, in order."""
        return list(self._used)

    def check(self, identity: str, next_index: int, now_us: int) -> None:
        """Return if the survey may be measured with an analyzer, and note it if it is new.

        Args:
            identity: What the connected instrument says it is.
            next_index: Index of the point that is measured next.
            now_us: The time [us since 1970, UTC].

        Raises:
            OtherAnalyzerError: It is another one, and the operator has not accepted it.
        """
        accept, self.accept = self.accept, ""
        former = self._used[-1].identity if self._used else identity
        other = _serial_number(identity) != _serial_number(former)
        if accept and accept != identity:
            raise OtherAnalyzerError(
                Message(
                    "the VNA is {present}, not {accepted}, which was accepted",
                    present=identity,
                    accepted=accept,
                ),
                identity if other else "",
            )
        if other and not accept:
            raise OtherAnalyzerError(
                Message(
                    "the VNA is {present}, but the survey was measured with {former}; connect "
                    "that VNA again, or accept the other one when you resume the survey",
                    present=identity,
                    former=former,
                ),
                identity,
            )
        if other or not self._used:
            self._used.append(UsedAnalyzer(identity, next_index, iso_text(now_us)))
        self.checked.set()


def _serial_number(identity: str) -> str:
    fields = [one.strip() for one in identity.split(",")]
    return fields[SERIAL_NUMBER] if len(fields) > SERIAL_NUMBER else identity


def recorded_analyzers(metadata_json: str, report_json: str) -> List[UsedAnalyzer]:
    """Return the analyzers of a survey that is on the disk.

    Args:
        metadata_json: As it was recorded at the survey's start.
        report_json: Its last report; empty if none exists.

    Raises:
        SurveyError: The report cannot be read.
    """
    try:
        used = json.loads(report_json).get(ANALYZERS, []) if report_json else []
        analyzers = [_from_fields(one) for one in used]
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise SurveyError(
            Message("the report in survey.json cannot be read", details=repr(error))
        ) from error
    if analyzers:
        return analyzers
    # Surveys of earlier versions have only the analyzer of their start.
    instrument = json.loads(metadata_json).get("instrument")
    identity = instrument.get("identity") if isinstance(instrument, dict) else None
    return [UsedAnalyzer(identity, 0, None)] if isinstance(identity, str) else []


def _from_fields(fields: Dict[str, Any]) -> UsedAnalyzer:
    identity, index, accepted = fields["identity"], fields["from_index"], fields["accepted"]
    if not isinstance(identity, str) or not isinstance(index, int):
        raise TypeError("an analyzer has no identity or no index")
    return UsedAnalyzer(identity, index, accepted if accepted is None else str(accepted))
