"""What was recorded of a survey's plan, and whether a stored trace fits it."""

from __future__ import annotations

import enum
import math
from dataclasses import astuple, dataclass
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.axes import MAX_STEP_SIZE, MIN_STEP_SIZE, Zeros, are_zeros
from gpr20_survey.plan.survey_parameters import (
    MAX_TRACES,
    RobotTravel,
    SurveyParameters,
    Travel,
    check,
)
from gpr20_survey.plan.survey_points import SurveyPoint, survey_points, visits
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import SURVEY_ID, Trace

IMPORTED = "imported"
"""Key of the description, and the outcome of these surveys."""
TIMES_KNOWN = "times_known"
"""Key of the entry: whether the times of the traces are those of the source."""
# Of a position; the values of a grid are those of its traces.
TOLERANCE = 1e-6
# The entry of the report.
ZEROS = "zeros"
UNPROVEN = Message("the zeros of the axes are not proven to be those of the traces before")
"""The remark on the quality of a trace whose zeros nobody has proven."""


@dataclass(frozen=True)
class ImportedGrid:
    """The places of an imported survey, each axis ascending."""

    polarization_deg: Tuple[float, ...]
    y_mm: Tuple[float, ...]
    x_mm: Tuple[float, ...]

    def __post_init__(self) -> None:
        axes = (self.polarization_deg, self.y_mm, self.x_mm)
        ascend = all(one < other for axis in axes for one, other in zip(axis, axis[1:]))
        if not ascend or not 1 <= math.prod(map(len, axes)) <= MAX_TRACES:
            raise InvalidValueError(Message("the axes of the grid are empty or do not ascend"))

    def points(self) -> List[SurveyPoint]:
        """Return the places in the order of their indices."""
        return visits(self.x_mm, self.y_mm, self.polarization_deg)


def is_imported(description: Mapping[str, Any]) -> bool:
    return IMPORTED in description


def import_of(description: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the entry of an imported survey; an empty one of any other."""
    found = description.get(IMPORTED)
    return found if isinstance(found, Mapping) else {}


def imported_grid(description: Mapping[str, Any]) -> ImportedGrid:
    """Return the grid of an imported survey.

    Raises:
        InvalidValueError: The description does not hold one.
    """
    try:
        return record_from(ImportedGrid, import_of(description), IMPORTED, others=True)
    except InvalidValueError as error:
        raise InvalidValueError(
            Message("the log does not hold the grid of the imported survey", details=error),
            fault=faults.DAMAGED,
        ) from error


def measured_area(description: Mapping[str, Any]) -> Any:
    """Return the entry `parameters`, as it was read; of an imported survey what its grid gives."""
    if not is_imported(description):
        return description.get("parameters")
    try:
        grid = imported_grid(description)
    except InvalidValueError:
        return None
    area: Dict[str, Any] = {"polarizations_deg": list(grid.polarization_deg)}
    for name, axis_mm in (("x", grid.x_mm), ("y", grid.y_mm)):
        area[f"{name}_start_mm"], area[f"{name}_stop_mm"] = axis_mm[0], axis_mm[-1]
        area[f"{name}_points"] = len(axis_mm)
    return area


def import_sentence(description: Mapping[str, Any]) -> Message:
    """Return from what a survey was imported, for people."""
    found = import_of(description)
    return Message(
        "imported from {source} ({format})",
        source=printable(str(found.get("source"))),
        format=printable(str(found.get("format"))),
    )


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
