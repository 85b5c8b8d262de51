"""What the robot is, as its nodes describe themselves, and what its other sensors say."""

from __future__ import annotations

import math
import threading
from dataclasses import asdict, dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, numeral
from gpr20_main_control.errors import CONFIGURATION_CHANGED, DeviceError
from gpr20_survey.faults import SENSOR_FAILED, WRONG_VNA
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import (
    ANALYZER,
    HEIGHT_SENSOR,
    PLAIN_NAMES,
    STORAGE,
    STORAGE_NAME,
    NodeDescription,
    RobotConfig,
    Sensor,
    is_simulated_identity,
    robot_config,
)
from gpr20_survey.trace.sweep import storable_remark
from gpr20_survey.trace.trace import AuxValue
from gpr20_survey.trace.utc_time import US_PER_S

# Without which no survey is measured, and what operators call them.
NEEDED_NODES = {**PLAIN_NAMES, STORAGE: STORAGE_NAME}
# Entries of survey.json that hold the configuration of a node.
RECORDED = {"height": HEIGHT_SENSOR, "analyzer": ANALYZER, "storage": STORAGE}


class DescribedRobot:
    """Holds the description of each node; every method may be called from any thread."""

    def __init__(self, site: Site, on_change: Callable[[DescribedRobot], None]) -> None:
        """Begin with no description; `on_change` is called after each new one."""
        self.site, self._on_change = site, on_change
        self._described = threading.Condition()
        self._nodes: Dict[str, NodeDescription] = {}
        self._config: Optional[RobotConfig] = None
        # Why no survey can be measured; None if nothing is wrong.
        self.problem: Optional[Message] = None
        self._judge()

    @property
    def nodes(self) -> Mapping[str, NodeDescription]:
        """The descriptions received so far, by their nodes."""
        with self._described:
            return dict(self._nodes)

    def note(self, description: NodeDescription) -> None:
        """Note what a node is now."""
        with self._described:
            self._nodes[description.node] = description
            self._judge()
            self._described.notify_all()
        self._on_change(self)

    def _judge(self) -> None:
        try:
            self._config, self.problem = robot_config(self._nodes), None
        except InvalidValueError as error:
            self._config, self.problem = None, error.message

    def config(self, wait_s: float = 0.0) -> RobotConfig:
        """Return what is fixed for the robot; nodes that are starting are waited for [s]."""
        with self._described:
            self._described.wait_for(lambda: self.problem is None, wait_s)
            if self.problem is not None:
                raise InvalidValueError(self.problem)
            assert self._config is not None
            return self._config

    def analyzer_address(self) -> str:
        """Return the address of the analyzer in the robot's configuration; empty: not known."""
        node = self.nodes.get(ANALYZER)
        return "" if node is None else str(node.configuration.get("address", ""))

    def check(self, config: RobotConfig) -> None:
        """Raise a DeviceError unless the robot is still the one with which a survey began."""
        try:
            present = self.config()
        except InvalidValueError as error:
            raise DeviceError(error.message) from error
        if present != config:
            raise DeviceError(
                Message(
                    "a part of the robot was restarted with another configuration than the survey "
                    "began with; end the launch, start it with the former configuration and "
                    "resume the survey"
                ),
                fault=CONFIGURATION_CHANGED,
            )

    def check_identity(self, identity: str, config: RobotConfig) -> None:
        """Raise a DeviceError unless the analyzer is simulated as the robot is."""
        if is_simulated_identity(identity) != config.simulated:
            raise DeviceError(
                Message(
                    "the VNA ({identity}) or the rest of the robot is simulated, but not both; "
                    "check the address of the VNA (127.0.0.1 if it is simulated), and the launch "
                    "(robot:=gpr20 if it is real)",
                    identity=identity,
                ),
                fault=WRONG_VNA,
            )

    def recorded(self) -> Dict[str, Any]:
        """Return what the log records about the nodes and the site."""
        nodes = self.nodes
        return {
            "nodes": [
                {**asdict(one.hardware), "hardware": one.hardware.name, "name": name}
                for name, one in sorted(nodes.items())
                if one.hardware.name
            ],
            **{
                key: dict(nodes[name].configuration)
                for key, name in RECORDED.items()
                if name in nodes
            },
            "site": asdict(self.site),
        }


@dataclass(frozen=True)
class Measured:
    """The last value of a sensor at a moment and its age [s], or why there is none that counts."""

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
    """The last message of one sensor; it is read only when it is needed."""

    def __init__(self, sensor: Sensor, read: Callable[[Any], float], clock: Clock) -> None:
        """Begin without a message; `read` returns the value in one, NaN if it holds none."""
        self.sensor = sensor
        self._read = read
        self._clock = clock
        self._last: Optional[Tuple[float, Any]] = None

    def note(self, content: Any) -> None:
        """Take a message; however many there are, this costs next to nothing."""
        self._last = self._clock.now_s(), content

    def now(self) -> Measured:
        """Return what is known now."""
        sensor, value, age_s = self.sensor, None, None
        if self._last is not None:
            received_s, content = self._last
            age_s = self._clock.now_s() - received_s
        if age_s is None or age_s > sensor.longest_age_s:
            reason = Message(
                "nothing has been received on {topic} for {longest_s:g} s; check that its node "
                "runs",
                topic=sensor.topic,
                longest_s=sensor.longest_age_s,
            )
        else:
            value = self._read(content)
            if math.isfinite(value) and sensor.is_plausible(value):
                return Measured(sensor, value, age_s, None)
            reason = Message(
                "its value {value} {unit} is not plausible; expected {low} to {high}",
                value=numeral(value, ".6g"),
                unit=sensor.unit,
                low="-" if sensor.low is None else numeral(sensor.low),
                high="-" if sensor.high is None else numeral(sensor.high),
            )
            value = value if math.isfinite(value) else None
        problem = Message("sensor {sensor}: {reason}", sensor=sensor.name, reason=reason)
        return Measured(sensor, value, age_s, problem.with_fault(SENSOR_FAILED))


class AuxSensors:
    """All other sensors of the robot; every method may be called from any thread."""

    def __init__(self, inputs: Sequence[SensorInput], clock: Clock) -> None:
        self._inputs = tuple(inputs)
        self._clock = clock

    def now(self) -> List[Measured]:
        """Return what each sensor says now."""
        return [one.now() for one in self._inputs]

    def check_required(self) -> List[Measured]:
        """Return what each says now; a DeviceError names one without which nothing is measured."""
        measured = self.now()
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
        return measured

    def for_trace(self) -> Tuple[Tuple[AuxValue, ...], Tuple[str, ...]]:
        """Return the values of a sweep that has just ended, and a remark on missing ones."""
        measured, now_us = self.check_required(), self._clock.time_of_day_us()
        values = tuple(
            AuxValue(
                one.sensor.name,
                one.value,
                one.sensor.unit,
                now_us - round((one.age_s or 0.0) * US_PER_S),
            )
            for one in measured
            if one.value is not None
        )
        problems = [str(one.problem) for one in measured if one.problem is not None]
        # One: a trace has room for 32 remarks of all kinds.
        return values, (storable_remark("; ".join(problems)),) if problems else ()

    def recorded(self) -> List[Dict[str, Any]]:
        """Return the entry `sensors` of survey.json."""
        return [asdict(one.sensor) for one in self._inputs]
