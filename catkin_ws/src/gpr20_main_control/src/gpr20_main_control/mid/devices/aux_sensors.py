"""The values of other sensors beside the radar, and which of them belongs to a trace."""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import asdict, dataclass
from typing import Any, Callable, Deque, Dict, List, Optional, Sequence, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import Clock
from gpr20_common.message import Fault, Message, numeral
from gpr20_main_control.errors import DeviceError
from gpr20_survey.faults import SENSOR_FAILED
from gpr20_survey.plan.sensors import Sensor
from gpr20_survey.trace.aux_value import AuxValue
from gpr20_survey.trace.sweep import storable_remark

# A sweep is this far back at most when its trace is made [s].
LONGEST_LAG_S = 10.0
# Of a sensor that publishes faster, not every message is kept until then [s].
SPACING_S = 0.01
KEPT = round(LONGEST_LAG_S / SPACING_S)
# Remarks of a trace on silent sensors; a trace has room for 32 of all kinds.
MAX_REMARKS = 4
US_PER_S = 1_000_000


@dataclass(frozen=True)
class Measured:
    """What a sensor said at a moment.

    Attributes:
        sensor: Which sensor.
        value: The last value that was received until then; None if there is none that counts.
        age_s: How old it was [s]; None if nothing was received.
        problem: Why it cannot be used, or is not plausible; None if all is well.
    """

    sensor: Sensor
    value: Optional[float]
    age_s: Optional[float]
    problem: Optional[Message]

    @property
    def message(self) -> Message:
        """The value in words, or what is wrong."""
        if self.problem is not None:
            return self.problem
        return Message(
            "{value:.6g} {unit}, received {age_s:.1f} s ago",
            value=self.value,
            unit=self.sensor.unit,
            age_s=self.age_s,
        )


class SensorInput:
    """The last messages of one sensor; they are read only when they are needed."""

    def __init__(self, sensor: Sensor, read: Callable[[Any], float], clock: Clock) -> None:
        """Begin without a message.

        Args:
            sensor: Which sensor.
            read: Returns the value in a message, or raises `InvalidValueError`.
            clock: When messages are received.
        """
        self.sensor = sensor
        self._read = read
        self._clock = clock
        self._lock = threading.Lock()
        self._kept: Deque[Tuple[float, Any]] = deque(maxlen=KEPT)
        self._last: Optional[Tuple[float, Any]] = None

    def note(self, content: Any) -> None:
        """Take a message; however many there are, this costs next to nothing."""
        now_s = self._clock.now_s()
        with self._lock:
            self._last = now_s, content
            if not self._kept or now_s - self._kept[-1][0] >= SPACING_S:
                self._kept.append(self._last)
            # Images of a camera would fill the memory otherwise.
            while len(self._kept) > 1 and self._kept[1][0] <= now_s - LONGEST_LAG_S:
                self._kept.popleft()

    def at(self, moment_s: float) -> Measured:
        """Return what was known at a moment of the clock [s]."""
        with self._lock:
            received = [*self._kept, *([self._last] if self._last else [])]
        before = [one for one in received if one[0] <= moment_s]
        if not before:
            return self._without(
                None,
                Message(
                    "nothing has been received on {topic}; check that its node runs",
                    topic=self.sensor.topic,
                ),
                SENSOR_FAILED,
            )
        received_s, content = before[-1]
        age_s = moment_s - received_s
        if age_s > self.sensor.longest_age_s:
            return self._without(
                age_s,
                Message(
                    "no value for {age_s} s, at most {longest_s:g} s are allowed; check that its "
                    "node runs",
                    age_s=numeral(age_s, ".1f"),
                    longest_s=self.sensor.longest_age_s,
                ),
                SENSOR_FAILED,
            )
        try:
            value = self._read(content)
        except InvalidValueError as error:
            # Its node and sensors.yaml do not agree.
            return self._without(age_s, error.message, CONFIGURATION)
        return self._judged(value, age_s)

    def _judged(self, value: float, age_s: float) -> Measured:
        if not math.isfinite(value):
            return self._without(
                age_s,
                Message("its value is {value}, not a finite number", value=str(value)),
                SENSOR_FAILED,
            )
        if self.sensor.is_plausible(value):
            return Measured(self.sensor, value, age_s, None)
        problem = Message(
            "its value {value} {unit} is not plausible; expected {low} to {high}",
            value=numeral(value, ".6g"),
            unit=self.sensor.unit,
            low="-" if self.sensor.low is None else numeral(self.sensor.low),
            high="-" if self.sensor.high is None else numeral(self.sensor.high),
        )
        return Measured(self.sensor, value, age_s, self._named(problem, SENSOR_FAILED))

    def _without(self, age_s: Optional[float], problem: Message, fault: Fault) -> Measured:
        return Measured(self.sensor, None, age_s, self._named(problem, fault))

    def _named(self, problem: Message, fault: Fault) -> Message:
        named = Message("sensor {sensor}: {reason}", sensor=self.sensor.name, reason=problem)
        return named.with_fault(fault)


class AuxSensors:
    """All other sensors of the robot; every method may be called from any thread."""

    def __init__(self, inputs: Sequence[SensorInput], clock: Clock) -> None:
        self._inputs = tuple(inputs)
        self._clock = clock

    def now(self) -> List[Measured]:
        """Return what each sensor says now."""
        now_s = self._clock.now_s()
        return [one.at(now_s) for one in self._inputs]

    def check_required(self) -> None:
        """Check the sensors without which no survey is measured.

        Raises:
            DeviceError: One is silent, or its value is not plausible.
        """
        _refuse_problems(self.now())

    def at_sweep(self, ended_us: int) -> Tuple[Tuple[AuxValue, ...], Tuple[str, ...]]:
        """Return the values that belong to a sweep, and remarks on those that are missing.

        Of each sensor it is the last value that was received until the sweep ended.

        Args:
            ended_us: When the sweep ended [us since 1970, UTC].

        Raises:
            DeviceError: A sensor that is required is silent, or its value is not plausible.
        """
        if not self._inputs:
            return (), ()
        # Counted from now, so that ages stay right when the time of day is set.
        lag_s = (self._clock.time_of_day_us() - ended_us) / US_PER_S
        moment_s = self._clock.now_s() - min(max(lag_s, 0.0), LONGEST_LAG_S)
        measured = [one.at(moment_s) for one in self._inputs]
        _refuse_problems(measured)
        values = tuple(
            AuxValue(
                one.sensor.name,
                one.value,
                one.sensor.unit,
                ended_us - round((one.age_s or 0.0) * US_PER_S),
            )
            for one in measured
            if one.value is not None
        )
        return values, _remarks(measured)

    def recorded(self) -> List[Dict[str, Any]]:
        """Return the entry `sensors` of survey.json."""
        return [asdict(one.sensor) for one in self._inputs]


def _refuse_problems(measured: Sequence[Measured]) -> None:
    for one in measured:
        if one.sensor.required and one.problem is not None:
            raise DeviceError(
                Message(
                    "{problem}; check this sensor and its cable, or set required: false in "
                    "sensors.yaml and launch again",
                    problem=one.problem,
                ),
                fault=SENSOR_FAILED,
            )


def _remarks(measured: Sequence[Measured]) -> Tuple[str, ...]:
    problems = [str(one.problem) for one in measured if one.problem is not None]
    more = len(problems) - MAX_REMARKS
    shown = [*problems[:MAX_REMARKS], *([f"{more} more sensors failed"] if more > 0 else [])]
    return tuple(map(storable_remark, shown))
