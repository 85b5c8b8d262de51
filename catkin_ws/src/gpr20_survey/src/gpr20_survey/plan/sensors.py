"""Other sensors beside the radar, as a robot's configuration names them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Iterator, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_survey.trace.trace import (
    AUX_NAME,
    AUX_UNIT,
    MAX_AUX_VALUES,
    MAX_UNIT_CHARACTERS,
    VNA_TEMPERATURE,
)

# Section of the configuration, and entry of the description.
SENSORS = "sensors"
# Relative or absolute; a private name would be below the name of the node that reads it.
TOPIC = re.compile(r"/?[A-Za-z]\w*(/[A-Za-z]\w*)*", re.ASCII)
MESSAGE = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*", re.ASCII)
FIELD = re.compile(r"[A-Za-z]\w*(\[\d{1,6}\])?(\.[A-Za-z]\w*(\[\d{1,6}\])?)*", re.ASCII)


@dataclass(frozen=True)
class Sensor:
    """One value of one other sensor.

    Attributes:
        name: Name of the value in traces and exports: a-z, 0-9 and _, such as soil_moisture.
        topic: Topic on which the sensor's node publishes, relative to the robot's namespace.
        message: Type of its messages, such as std_msgs/Float64.
        field: Field that holds the value, such as data, or a.b[0] inside other fields.
        unit: Unit of the value, such as degC.
        longest_age_s: A value that was received longer ago than this counts as silence [s].
        required: true: the survey pauses when the sensor is silent or its value is not plausible;
            false: the trace gets a remark.
        low: Lowest plausible value; leave it out if there is none.
        high: Highest plausible value; leave it out if there is none.
    """

    name: str
    topic: str
    message: str
    field: str
    unit: str = ""
    longest_age_s: float = bounded(0.05, 3600.0, 5.0)
    required: bool = False
    low: Optional[float] = None
    high: Optional[float] = None

    def __post_init__(self) -> None:
        for mistake in self._mistakes():
            raise InvalidValueError(mistake, fault=CONFIGURATION)

    def _mistakes(self) -> Iterator[Message]:
        for key, pattern, example in (
            ("name", AUX_NAME, "soil_moisture"),
            ("topic", TOPIC, "soil_probe/moisture"),
            ("message", MESSAGE, "std_msgs/Float64"),
            ("field", FIELD, "data"),
        ):
            value = getattr(self, key)
            if not pattern.fullmatch(value):
                yield Message(
                    "{key} of sensor {sensor} is {value}; it must be like {example}",
                    key=key,
                    sensor=repr(self.name[:64]),
                    value=repr(value[:64]),
                    example=example,
                )
        if not AUX_UNIT.holds(self.unit):
            yield Message(
                "unit of sensor {sensor} is {value}; it must be printable and have at most {most} "
                "characters",
                sensor=self.name,
                value=repr(self.unit[:64]),
                most=MAX_UNIT_CHARACTERS,
            )
        if self.low is not None and self.high is not None and self.low >= self.high:
            yield Message(
                "low and high of sensor {sensor} are {low:g} and {high:g}; low must be below high",
                sensor=self.name,
                low=self.low,
                high=self.high,
            )

    def is_plausible(self, value: float) -> bool:
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class Sensors:
    """The other sensors of a robot.

    Attributes:
        sensors: One group of keys for each value that is stored with every trace.
    """

    sensors: Tuple[Sensor, ...] = ()

    def __post_init__(self) -> None:
        names = [VNA_TEMPERATURE, *(one.name for one in self.sensors)]
        if len(names) > MAX_AUX_VALUES:
            message = Message(
                "there are {count} sensors; at most {most} are allowed",
                count=len(self.sensors),
                most=MAX_AUX_VALUES - 1,
            )
            raise InvalidValueError(message, fault=CONFIGURATION)
        for name in names:
            if names.count(name) > 1:
                raise InvalidValueError(
                    Message("two sensors have the name {name}; give each its own", name=name),
                    fault=CONFIGURATION,
                )

    @property
    def topics(self) -> Tuple[str, ...]:
        return tuple(one.topic for one in self.sensors)
