"""What the instrument says of a trace: the answer to `:TRACe:PREamble?`.

The names are those of table 3-12 of the MS20xxC programming manual. Which of them a unit reports
depends on its firmware.
"""

from __future__ import annotations

import re
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message, in_a_row
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_vna_acquisition.errors import VnaReplacedError, VnaSettingError
from gpr20_vna_acquisition.mid import settings
from gpr20_vna_acquisition.mid.block_parser import text_block

PREAMBLE_QUERY = ":TRAC:PRE? 1"
SERIAL = "SN"
# What a setting is called in a preamble; one of several names is enough.
NAMES_OF_SETTINGS: Dict[str, Tuple[str, ...]] = {
    settings.HOLD.header: ("SWEEP_TYPE",),
    settings.START: ("TRACE_1_START_FREQ",),
    settings.STOP: ("TRACE_1_STOP_FREQ",),
    settings.POINTS: ("TRACE_1_DSP_DATA_POINTS",),
    settings.ONE_TRACE.header: ("TOTAL_TRACE",),
    settings.S21.header: ("TRACE_S_TYPES", "S_TYPE"),
    settings.FREQUENCY_DOMAIN.header: ("TRACE_DOMAIN_TYPES", "DOMAIN"),
    settings.IF_BANDWIDTH_QUERY[:-1]: ("IFBW",),
    settings.AVERAGES_QUERY[:-1]: ("AVERAGING_FACTOR",),
    settings.POWER_QUERY[:-1]: ("RF_SOURCE_POWER",),
}
SMOOTHING, MATH = ("SMOOTHING_PERCENT", "TRACE_SMOOTHING_PERCENT"), ("TRACE_MATH_TYPES",)
# The four traces share these numbers; what belongs to trace 1 is in the lowest bits.
FIRST_SMOOTHING, FIRST_MATH = 0xFF, 0xF
# Everything that must not change during a survey.
_WATCHED = tuple(name for names in NAMES_OF_SETTINGS.values() for name in names) + (
    *SMOOTHING,
    *MATH,
    "APP_VER",
    "SUB_MODE",
)
_NUMBER = re.compile(r"[+-]?[0-9]{1,12}(?:\.[0-9]{0,12})?")
# The temperature is in quarters of a degree, and only valid with a calibration.
QUARTERS_PER_DEGREE = 4.0
CORRECTION_ON = 0.0


class Preamble:
    """One answer.

    Attributes:
        said: What it says, by name.
    """

    def __init__(self, answer: bytes) -> None:
        """Read an answer.

        Raises:
            VnaDataError: It is not a complete block.
        """
        pairs = (pair.partition("=") for pair in text_block(answer).split(","))
        self.said = {name.strip(): value.strip() for name, _equal, value in pairs}

    def number(self, *names: str) -> Optional[float]:
        """Return the first number of these names, without its unit; None if there is none."""
        for name in names:
            found = _NUMBER.match(self.said.get(name, ""))
            if found:
                return float(found.group())
        return None

    @property
    def is_corrected(self) -> Optional[bool]:
        """Whether the calibration is applied; None if it does not say."""
        correction = self.number("CAL_CORRECTION")
        return None if correction is None else correction == CORRECTION_ON

    @property
    def temperature_c(self) -> Optional[float]:
        """Temperature of the instrument [degC]; None if it does not say."""
        quarters = self.number("CURRENT_TEMPERATURE")
        if quarters is None or not self.is_corrected:
            return None
        return quarters / QUARTERS_PER_DEGREE

    @property
    def smoothing_percent(self) -> Optional[int]:
        """How much of the sweep is averaged for each point [%]; None if it does not say."""
        found = self.number(*SMOOTHING)
        return None if found is None else int(found) & FIRST_SMOOTHING

    @property
    def trace_math(self) -> Optional[int]:
        """How trace 1 is combined with its memory; 0: not at all; None if it does not say."""
        found = self.number(*MATH)
        return None if found is None else int(found) & FIRST_MATH

    def covers(self, header: str) -> bool:
        """Return whether it shows every change of a setting."""
        return any(name in self.said for name in NAMES_OF_SETTINGS.get(header, ()))

    def check_unprocessed(self) -> None:
        """Do nothing if the trace is what was measured.

        Raises:
            VnaSettingError: It is smoothed, or combined with a memory.
        """
        for name, value in (("smoothing", self.smoothing_percent), ("math", self.trace_math)):
            if value:
                raise VnaSettingError(
                    Message(
                        "the VNA processes its trace ({what}); switch smoothing and trace math off",
                        what=f"{name} {value}",
                    ),
                    fault=VNA_SETTINGS,
                )

    def differing(self, now: Preamble) -> List[Tuple[str, str, str]]:
        """Return name, former and present value of everything watched that is different now.

        Raises:
            VnaReplacedError: The other one is of another instrument.
        """
        former, serial = self.said.get(SERIAL), now.said.get(SERIAL)
        if former != serial:
            raise replaced(str(serial), str(former))
        pairs = ((name, self.said.get(name), now.said.get(name)) for name in _WATCHED)
        return [(name, str(one), str(other)) for name, one, other in pairs if one != other]


def changed_values(
    changed: Sequence[Tuple[str, str, str]], settings_names: Mapping[str, Message]
) -> Message:
    """Return a sentence on values that changed.

    Args:
        changed: As `Preamble.differing` returned them.
        settings_names: What people call the settings, by header.
    """
    headers = {name: header for header, names in NAMES_OF_SETTINGS.items() for name in names}
    return in_a_row(
        Message(
            "{setting} was {former} and is {now}",
            setting=settings_names.get(headers.get(name, ""), name),
            former=former[:40],
            now=now[:40],
            details=f"{headers.get(name, '')} {name}".strip(),
        )
        for name, former, now in changed
    )


def replaced(now: str, former: str) -> VnaReplacedError:
    """Return the error of an instrument that is another one, on the same link."""
    return VnaReplacedError(
        Message(
            "the VNA is now {now} and was {former}; connect the former VNA again, or accept the "
            "other one when you connect or resume",
            now=repr(now[:80]),
            former=repr(former[:80]),
        )
    )
