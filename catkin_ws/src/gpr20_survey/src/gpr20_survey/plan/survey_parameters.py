"""What a survey measures, how the control carries it out, and what is allowed."""

from __future__ import annotations

import enum
import hashlib
import json
import math
import re
from dataclasses import asdict, dataclass
from typing import Any, Iterator, List, Tuple, Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, in_a_row, numeral
from gpr20_common.mid.checks import instrument_address, number_between
from gpr20_common.mid.codec import bounded
from gpr20_survey import faults
from gpr20_survey.trace.sweep import (
    MAX_AVERAGES,
    MAX_FREQUENCY_HZ,
    MAX_FREQUENCY_POINTS,
    MIN_FREQUENCY_HZ,
    MIN_FREQUENCY_POINTS,
    MIN_FREQUENCY_SPACING_HZ,
    AnalyzerSettings,
    SweepSettings,
)

# Wider than those of the MS2026C: other analyzers have other values. The driver checks the rest.
MIN_IF_BANDWIDTH_HZ, MAX_IF_BANDWIDTH_HZ = 1.0, 1.0e7
OUTPUT_POWER = re.compile(r"(LOW|HIGH|[+-]?[0-9]{1,3}([.][0-9]{1,2})?(dBm)?)?")
# The area that the parameters of a survey may name; each axis may allow less.
MIN_COORDINATE_MM = 0.0
MAX_COORDINATE_MM = 800.0
MIN_GRID_POINTS = 3
MAX_TRACES = 1_000_000
MAX_POLARIZATIONS = 36
# How far a rotation may be from a motor step, as a part of it.
ON_STEP = 1.0e-6
DEFAULT_POLARIZATIONS_DEG = (0.0, 90.0)


@dataclass(frozen=True)
class Travel:
    """What one axis can do: its range and its step [mm, or deg for a rotary axis]."""

    lower: float
    upper: float
    step: float


@dataclass(frozen=True)
class RobotTravel:
    x: Travel
    y: Travel
    z: Travel


@dataclass(frozen=True)
class SurveyParameters:
    """What a survey measures; frequencies in Hz, coordinates in mm, rotations in degrees.

    An empty `vna_address` means that of the robot's configuration. `if_bandwidth_hz`, `averages`
    and `output_power` are settings of the VNA; 0 or empty leaves them as the instrument has them.
    """

    vna_address: str
    start_frequency_hz: float
    stop_frequency_hz: float
    frequency_points: int
    x_start_mm: float
    x_stop_mm: float
    x_points: int
    y_start_mm: float
    y_stop_mm: float
    y_points: int
    polarizations_deg: Tuple[float, ...] = DEFAULT_POLARIZATIONS_DEG
    if_bandwidth_hz: float = 0.0
    averages: int = 0
    output_power: str = ""

    @property
    def total_points(self) -> int:
        """Number of traces: one per stop and polarization."""
        return self.x_points * self.y_points * len(self.polarizations_deg)

    @property
    def plan_id(self) -> str:
        """What only these parameters have: 16 hexadecimal digits."""
        content = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    @property
    def sweep_settings(self) -> SweepSettings:
        return SweepSettings(
            self.start_frequency_hz,
            self.stop_frequency_hz,
            self.frequency_points,
            AnalyzerSettings(self.if_bandwidth_hz, self.averages, self.output_power),
        )


class HeightPolicy(enum.Enum):
    """What a survey does when the antenna height cannot be measured."""

    PAUSE = "pause"
    STORE_WITHOUT = "store_without"


@dataclass(frozen=True)
class SurveySettings:
    """How the control carries out surveys; set for a robot, not for a survey.

    Attributes:
        settle_s: Time for vibrations to die down between a move and the sweep [s].
        height_s: Time that the height measurement takes [s]; for the estimate only.
        attempts: How often a height measurement is tried before the survey pauses.
        on_height_failure: `pause`, or `store_without` to store the trace with no height.
        return_limit_s: How long a survey waits for a node that is gone, or for a link that is
            down, before it pauses [s].
        repeat_limit_db: A point that is measured again agrees with its stored trace if they differ
            by no more than this, relative to the trace [dB].
        reference_interval_s: Time after which the survey returns to its first stop to see the
            drift [s]; a shorter survey never returns. 0: none does.
        drift_limit_db: Largest drift of the amplitude, root mean square over the band [dB]; after
            a larger one the survey pauses.
        drift_limit_deg: Largest drift of the phase, root mean square over the band [deg]; after a
            larger one the survey pauses.
    """

    settle_s: float = bounded(0.0, 60.0, 0.5)
    height_s: float = bounded(0.0, 60.0, 0.4)
    attempts: int = bounded(1, 100, 3)
    on_height_failure: HeightPolicy = HeightPolicy.PAUSE
    return_limit_s: float = bounded(0.0, 3600.0, 300.0)
    repeat_limit_db: float = bounded(-100.0, 0.0, -20.0)
    reference_interval_s: float = bounded(0.0, 1.0e6, 3600.0)
    drift_limit_db: float = bounded(0.01, 100.0, 1.0)
    drift_limit_deg: float = bounded(0.1, 180.0, 10.0)


class Relation(enum.Enum):
    """Rules about several parameters; each value names those that are to be corrected."""

    FREQUENCY_ORDER = ("start_frequency_hz",)
    FREQUENCY_SPACING = ("frequency_points",)
    X_SPACING = ("x_points",)
    Y_SPACING = ("y_points",)
    SIZE = ("x_points", "y_points")


@dataclass(frozen=True)
class Problem:
    """A parameter that is not allowed by itself, or a relation that does not hold, and how."""

    of: Union[str, Relation]
    message: Message


def check(parameters: SurveyParameters, travel: RobotTravel) -> None:
    """Refuse parameters that the robot cannot or should not carry out.

    Raises:
        InvalidValueError: Naming every parameter that is wrong.
    """
    found = [one.message for one in find_problems(parameters, travel)]
    if found:
        raise InvalidValueError(in_a_row(found), fault=faults.PLAN_NOT_ALLOWED)


def find_problems(parameters: SurveyParameters, travel: RobotTravel) -> List[Problem]:
    """Return everything that is not allowed; empty if all is."""
    p, within = parameters, number_between
    hz = (MIN_FREQUENCY_HZ, MAX_FREQUENCY_HZ, "Hz")
    points, stops = (MIN_FREQUENCY_POINTS, MAX_FREQUENCY_POINTS), (MIN_GRID_POINTS, MAX_TRACES)
    x_mm, y_mm = (*coordinate_limits_mm(travel.x), "mm"), (*coordinate_limits_mm(travel.y), "mm")
    bandwidths_hz = (MIN_IF_BANDWIDTH_HZ, MAX_IF_BANDWIDTH_HZ, "Hz")
    # 0: as the instrument has it.
    bandwidth_hz = p.if_bandwidth_hz or MIN_IF_BANDWIDTH_HZ
    traces = p.total_points if min(p.x_points, p.y_points) >= MIN_GRID_POINTS else 1
    checks: List[Tuple[Any, ...]] = [
        ("vna_address", check_address, p.vna_address),
        ("start_frequency_hz", within, Message("start frequency"), p.start_frequency_hz, *hz),
        ("stop_frequency_hz", within, Message("stop frequency"), p.stop_frequency_hz, *hz),
        ("frequency_points", within, Message("frequency points"), p.frequency_points, *points),
        ("if_bandwidth_hz", within, Message("IF bandwidth"), bandwidth_hz, *bandwidths_hz),
        ("averages", within, Message("averages"), p.averages, 0, MAX_AVERAGES),
        ("output_power", check_output_power, p.output_power),
        ("x_start_mm", within, Message("x start"), p.x_start_mm, *x_mm),
        ("x_stop_mm", within, Message("x stop"), p.x_stop_mm, *x_mm),
        ("x_points", within, Message("x points"), p.x_points, *stops),
        ("y_start_mm", within, Message("y start"), p.y_start_mm, *y_mm),
        ("y_stop_mm", within, Message("y stop"), p.y_stop_mm, *y_mm),
        ("y_points", within, Message("y points"), p.y_points, *stops),
        ("polarizations_deg", _polarizations, p.polarizations_deg, travel.z),
        (Relation.SIZE, within, Message("number of traces"), traces, 1, MAX_TRACES),
    ]
    found: List[Tuple[Union[str, Relation], Message]] = list(_broken_relations(p, travel))
    for of, check_one, *values in checks:
        try:
            check_one(*values)
        except InvalidValueError as error:
            found.append((of, error.message))
    return [Problem(of, one.with_fault(faults.PLAN_NOT_ALLOWED)) for of, one in found]


def _broken_relations(
    p: SurveyParameters, travel: RobotTravel
) -> Iterator[Tuple[Relation, Message]]:
    # A number that is not finite, or too small, is refused by itself.
    if p.start_frequency_hz >= p.stop_frequency_hz:
        reason = Message(
            "start frequency is {start} Hz; it must be below the stop frequency, {stop} Hz",
            start=numeral(p.start_frequency_hz, ".12g"),
            stop=numeral(p.stop_frequency_hz, ".12g"),
        )
        yield Relation.FREQUENCY_ORDER, reason
    gaps = p.frequency_points - 1
    spacing_hz = (p.stop_frequency_hz - p.start_frequency_hz) / gaps if gaps > 0 else math.inf
    if 0.0 < spacing_hz < MIN_FREQUENCY_SPACING_HZ:
        reason = Message(
            "start frequency, stop frequency and points give frequencies {spacing} Hz apart; "
            "they must be at least {least:g} Hz apart",
            spacing=numeral(spacing_hz, ".6g"),
            least=MIN_FREQUENCY_SPACING_HZ,
        )
        yield Relation.FREQUENCY_SPACING, reason
    for axis, relation, span_mm, points, step_mm in (
        ("x", Relation.X_SPACING, p.x_stop_mm - p.x_start_mm, p.x_points, travel.x.step),
        ("y", Relation.Y_SPACING, p.y_stop_mm - p.y_start_mm, p.y_points, travel.y.step),
    ):
        # Two stops on the same motor step would be the same place measured twice.
        if points >= MIN_GRID_POINTS and abs(span_mm) / (points - 1) < step_mm:
            reason = Message(
                "{axis} start, stop and points give {points} stops {spacing_mm:.6g} mm apart; "
                "they must be at least one motor step, {step_mm:g} mm, apart",
                axis=axis,
                points=points,
                spacing_mm=abs(span_mm) / (points - 1),
                step_mm=step_mm,
            )
            yield relation, reason


def coordinate_limits_mm(travel: Travel) -> Tuple[float, float]:
    """Return the coordinates [mm] that a survey may name on a linear axis."""
    return max(MIN_COORDINATE_MM, travel.lower), min(MAX_COORDINATE_MM, travel.upper)


def check_address(address: str) -> None:
    """Return if the text can be the address of an analyzer.

    Raises:
        InvalidValueError: It cannot.
    """
    # Empty: that of the robot's configuration.
    if address:
        instrument_address(Message("VNA address"), address)


def check_output_power(power: str) -> None:
    """Refuse what no analyzer has, with InvalidValueError; empty: as it is set."""
    if not OUTPUT_POWER.fullmatch(power):
        raise InvalidValueError(
            Message(
                "output power is {power}; use LOW or HIGH, or a level such as -10dBm for another "
                "VNA than the MS2026C",
                power=repr(power[:64]),
            )
        )


def _polarizations(rotations_deg: Tuple[float, ...], travel: Travel) -> None:
    number_between(Message("number of polarizations"), len(rotations_deg), 1, MAX_POLARIZATIONS)
    for rotation_deg in rotations_deg:
        number_between(
            Message("polarization"), rotation_deg, travel.lower, travel.upper, Message("deg")
        )
        if abs(rotation_deg / travel.step - round(rotation_deg / travel.step)) > ON_STEP:
            raise InvalidValueError(
                Message(
                    "polarization is {rotation_deg} deg; it must be a multiple of the motor's "
                    "step, {step_deg:g} deg",
                    rotation_deg=numeral(rotation_deg, ".12g"),
                    step_deg=travel.step,
                )
            )
    if len({round(one / travel.step) for one in rotations_deg}) != len(rotations_deg):
        raise InvalidValueError(
            Message(
                "polarizations are {listed} deg; they must differ by at least {step_deg:g} deg",
                listed=tuple(map(numeral, rotations_deg)),
                step_deg=travel.step,
            )
        )
