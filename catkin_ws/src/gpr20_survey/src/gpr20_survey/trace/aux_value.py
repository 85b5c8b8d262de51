"""What another sensor beside the radar measured at a trace."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Sequence

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.trace.sweep import check_time, refuse, shortened
from gpr20_survey.trace.trace_form import FLOAT64, TEXT, TIME, of

MAX_AUX_VALUES = 32
MAX_UNIT_CHARACTERS = 32
# Of the analyzer itself; no other sensor has this name.
VNA_TEMPERATURE = "vna_temperature"
AUX_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")


@dataclass(frozen=True)
class AuxValue:
    """One value of one sensor."""

    name: str = field(metadata=of(TEXT, "name of the value, such as `soil_moisture`"))
    value: float = field(metadata=of(FLOAT64, "a finite number"))
    unit: str = field(metadata=of(TEXT, "its unit; may be empty"))
    stamp_us: int = field(metadata=of(TIME, "when the robot received it"))


def vna_temperature(temperature_c: float, stamp_us: int) -> AuxValue:
    """Return the temperature of the analyzer [degC] as a value of a trace."""
    return AuxValue(VNA_TEMPERATURE, temperature_c, "degC", stamp_us)


def check_aux(values: Sequence[AuxValue]) -> None:
    """Refuse values that a trace must not hold.

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """
    if len(values) > MAX_AUX_VALUES:
        refuse(
            Message(
                "aux has {count} values; at most {most} are allowed",
                count=len(values),
                most=MAX_AUX_VALUES,
            ),
            fault=CONFIGURATION,
        )
    for one in values:
        _check(one)
    names = [one.name for one in values]
    for name in names:
        if names.count(name) > 1:
            refuse(
                Message("aux has the name {name} twice", name=shortened(name)),
                fault=CONFIGURATION,
            )


def is_aux_unit(unit: str) -> bool:
    """Return whether a text can be the unit of a value."""
    return len(unit) <= MAX_UNIT_CHARACTERS and unit.isprintable()


def _check(one: AuxValue) -> None:
    if not AUX_NAME.fullmatch(one.name):
        refuse(
            Message(
                "aux has a value named {name}; a name must have 1 to 64 of a-z, 0-9 and _, and "
                "begin with a letter",
                name=shortened(one.name),
            ),
            fault=CONFIGURATION,
        )
    if not math.isfinite(one.value):
        refuse(
            Message(
                "{name} in aux is {value}; it must be finite", name=one.name, value=str(one.value)
            ),
            fault=faults.SENSOR_NOT_FINITE,
        )
    if not is_aux_unit(one.unit):
        refuse(
            Message(
                "{name} in aux has the unit {unit}; it must be printable and have at most {most} "
                "characters",
                name=one.name,
                unit=shortened(one.unit),
                most=MAX_UNIT_CHARACTERS,
            ),
            fault=CONFIGURATION,
        )
    check_time(f"{one.name} in aux", one.stamp_us)
