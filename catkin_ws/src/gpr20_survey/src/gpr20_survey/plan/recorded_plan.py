"""What was recorded of a survey's plan, and whether a stored trace fits it."""

from __future__ import annotations

import enum
from dataclasses import astuple, dataclass
from typing import Any, List, Mapping, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_survey import faults
from gpr20_survey.axes.axis_id import Zeros, are_zeros
from gpr20_survey.axes.axis_parameters import MAX_STEP_SIZE, MIN_STEP_SIZE
from gpr20_survey.plan.imported import TOLERANCE, imported_grid, is_imported
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel, check
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import SURVEY_ID, Trace

# The entry of the report.
ZEROS = "zeros"
UNPROVEN = Message("the zeros of the axes are not proven to be those of the traces before")
"""The remark on the quality of a trace whose zeros nobody has proven."""


class Proof(enum.Enum):
    """How it is known that the coordinates of other zeros are those of the survey."""

    START = "start"
    """They are the zeros of the first trace."""
    MEASURED = "measured"
    """The survey homed the axes itself, and a known point agreed at every rotation."""
    ACCEPTED = "accepted"
    """Nothing proves it; the operator decided to continue."""


@dataclass(frozen=True)
class UsedZeros:
    """Zeros of a part of a survey.

    Attributes:
        from_index: Index of the first trace that was to be measured with them.
        time: When the survey began to use them, ISO 8601.
        proof: How it is known that they are where the former ones were.
    """

    zeros: Zeros
    from_index: int
    time: str
    proof: Proof

    def __post_init__(self) -> None:
        if not are_zeros(self.zeros):
            raise InvalidValueError(Message("zeros are not those of three axes"))


REFINES = "refines"
"""Key of the description; only in a survey that measures a part of another one more finely."""
ANTENNA_DELAYS_NS = (-100.0, 100.0)
"""Smallest and largest delay of cables and antennas [ns]; 100 ns are 20 m of cable."""
# Some analyzers list their frequencies in single precision [Hz].
FREQUENCY_TOLERANCE_HZ = 512.0


@dataclass(frozen=True)
class _Axis:
    min_coord: float
    max_coord: float
    step_size: float = bounded(MIN_STEP_SIZE, MAX_STEP_SIZE)


@dataclass(frozen=True)
class _Axes:
    x: _Axis
    y: _Axis
    z: _Axis


def recorded_plan(description: Mapping[str, Any]) -> Tuple[SurveyParameters, RobotTravel]:
    """Return the parameters of a survey and the travel of its axes.

    Raises:
        InvalidValueError: Parameters or axes are missing or not allowed.
    """
    try:
        axes = record_from(_Axes, description.get("axes"), "axes", others=True)
        travel = RobotTravel(*(Travel(*astuple(one)) for one in (axes.x, axes.y, axes.z)))
        parameters = record_from(SurveyParameters, description.get("parameters"), "parameters")
        check(parameters, travel)
    except InvalidValueError as error:
        # Nobody can correct the plan of a survey that was measured.
        raise InvalidValueError(error.message, fault=faults.DAMAGED) from error
    return parameters, travel


def recorded_settings(description: Mapping[str, Any]) -> AnalyzerSettings:
    """Return the settings that the analyzer had when a survey began; empty if not recorded."""
    try:
        sweep = description["instrument"]["sweep"]
        return record_from(AnalyzerSettings, sweep, "sweep", others=True)
    except (KeyError, TypeError, InvalidValueError):
        return AnalyzerSettings()  # not every analyzer says them


def refines_of(description: Mapping[str, Any]) -> str:
    """Return the id of the survey that one refines; empty if it refines none.

    An entry that is no survey's id counts as none: it only says what to show beside the survey.
    """
    value = description.get(REFINES)
    return value if isinstance(value, str) and SURVEY_ID.fullmatch(value) else ""


class PlanFit:
    """Compares traces with the plan of a survey, or with the grid of an imported one."""

    def __init__(self, description: Mapping[str, Any]) -> None:
        """Compute the plan.

        Raises:
            InvalidValueError: Parameters, axes or the grid are missing or not allowed.
        """
        self._recorded = self._wanted = AnalyzerSettings()
        self._frequencies_hz: Optional[np.ndarray] = None
        if is_imported(description):
            self.points = imported_grid(description).points()
            self._tolerances = [TOLERANCE] * 3
            return
        parameters, travel = recorded_plan(description)
        self.points = survey_points(parameters, travel)
        # Both are whole motor steps: more than half a step apart is another position.
        self._tolerances = [one.step / 2 for one in (travel.x, travel.y, travel.z)]
        self._frequencies_hz = parameters.sweep_settings.frequencies_hz()
        self._wanted = parameters.sweep_settings.analyzer
        self._recorded = recorded_settings(description)

    def misfits(self, trace: Trace) -> List[Message]:
        """Return the differences between a trace and the plan for its index."""
        return (
            self.misplaced(trace)
            or self._other_frequencies(trace)
            or _other_settings(trace, self._wanted)
        )

    def changed_settings(self, trace: Trace) -> List[Message]:
        """Return how the analyzer's settings differ from those at the start of the survey."""
        return _other_settings(trace, self._recorded)

    def misplaced(self, trace: Trace) -> List[Message]:
        """Return the same as `misfits`, but of the frequencies only their number."""
        if trace.index >= len(self.points):
            return [
                Message(
                    "trace {index} was not planned; the plan has {planned} traces",
                    index=trace.index,
                    planned=len(self.points),
                )
            ]
        point = self.points[trace.index]
        own = (trace.x_coord_mm, trace.y_coord_mm, trace.z_coord_deg)
        planned = (point.x_mm, point.y_mm, point.z_deg)
        found = [
            Message(
                "trace {index} was measured at {axis} {position:g} instead of {planned:g}",
                index=trace.index,
                axis=axis,
                position=one,
                planned=other,
            )
            for axis, one, other, tolerance in zip("xyz", own, planned, self._tolerances)
            if abs(one - other) > tolerance
        ]
        frequencies_hz = self._frequencies_hz
        if frequencies_hz is not None and len(trace.frequency_hz) != len(frequencies_hz):
            found.append(
                Message(
                    "trace {index} has {count} frequencies instead of {planned}",
                    index=trace.index,
                    count=len(trace.frequency_hz),
                    planned=len(frequencies_hz),
                )
            )
        return found

    def _other_frequencies(self, trace: Trace) -> List[Message]:
        own, planned = trace.frequency_hz, self._frequencies_hz
        if planned is None or np.allclose(own, planned, rtol=0.0, atol=FREQUENCY_TOLERANCE_HZ):
            return []
        first = int(np.argmax(np.abs(own - planned) > FREQUENCY_TOLERANCE_HZ))
        return [
            Message(
                "trace {index} was measured at {frequency_hz:.12g} Hz instead of "
                "{planned_hz:.12g} Hz",
                index=trace.index,
                frequency_hz=float(own[first]),
                planned_hz=float(planned[first]),
            )
        ]


def _other_settings(trace: Trace, wanted: AnalyzerSettings) -> List[Message]:
    if trace.analyzer.fulfils(wanted):
        return []
    return [
        Message(
            "trace {index} was measured with other settings of the VNA: {own} instead of {wanted}",
            index=trace.index,
            own=trace.analyzer.message,
            wanted=wanted.message,
        )
    ]
