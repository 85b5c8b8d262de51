"""What another sensor beside the radar measured at a trace."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_survey.trace import trace_form as forms

MAX_AUX_VALUES = 32
MAX_UNIT_CHARACTERS = 32
# Of the analyzer itself; no other sensor has this name.
VNA_TEMPERATURE = "vna_temperature"
AUX_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
_NAMED = Message("1 to 64 of a-z, 0-9 and _, the first a letter")
_NAME = forms.Rule(AUX_NAME.fullmatch, _NAMED, CONFIGURATION)
AUX_UNIT = forms.printable(MAX_UNIT_CHARACTERS, CONFIGURATION)


@dataclass(frozen=True)
class AuxValue:
    """One value of one sensor."""

    name: str = forms.of(forms.TEXT, "such as `soil_moisture`", rule=_NAME)
    value: float = forms.of(forms.FLOAT64, "a finite number")
    unit: str = forms.of(forms.TEXT, "its unit; may be empty", rule=AUX_UNIT)
    stamp_us: int = forms.of(forms.TIME, "when the robot received it")


AUX_RULE = forms.Rule(
    lambda values: len({one.name for one in values}) == len(values) <= MAX_AUX_VALUES,
    Message("at most {most} values, none of them twice", most=MAX_AUX_VALUES),
    CONFIGURATION,
)
