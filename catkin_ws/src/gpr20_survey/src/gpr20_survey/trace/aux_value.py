"""What another sensor beside the radar measured at a trace."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_survey.trace.trace_form import FLOAT64, TEXT, TIME, of
from gpr20_survey.trace.trace_rule import FINITE, PLAUSIBLE, Rule, printable

MAX_AUX_VALUES = 32
MAX_UNIT_CHARACTERS = 32
# Of the analyzer itself; no other sensor has this name.
VNA_TEMPERATURE = "vna_temperature"
AUX_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
_NAME = Rule(
    lambda name: AUX_NAME.fullmatch(name) is not None,
    Message("1 to 64 of a-z, 0-9 and _, the first a letter"),
    CONFIGURATION,
)
AUX_UNIT = printable(MAX_UNIT_CHARACTERS, CONFIGURATION)


@dataclass(frozen=True)
class AuxValue:
    """One value of one sensor."""

    name: str = field(metadata=of(TEXT, "such as `soil_moisture`", rule=_NAME))
    value: float = field(metadata=of(FLOAT64, "a finite number", rule=FINITE))
    unit: str = field(metadata=of(TEXT, "its unit; may be empty", rule=AUX_UNIT))
    stamp_us: int = field(metadata=of(TIME, "when the robot received it", rule=PLAUSIBLE))


def vna_temperature(temperature_c: float, stamp_us: int) -> AuxValue:
    """Return the temperature of the analyzer [degC] as a value of a trace."""
    return AuxValue(VNA_TEMPERATURE, temperature_c, "degC", stamp_us)


AUX_RULE = Rule(
    lambda values: len({one.name for one in values}) == len(values) <= MAX_AUX_VALUES,
    Message("at most {most} values, none of them twice", most=MAX_AUX_VALUES),
    CONFIGURATION,
)
