"""Whether a stored trace is one of those that a survey planned."""

from __future__ import annotations

import dataclasses
from typing import Any, List, Mapping

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.plan.recorded_plan import recorded_plan
from gpr20_survey.plan.survey_plan import SurveyPoint, survey_points
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

# Early versions stored the instrument's own list, which is in single precision [Hz].
FREQUENCY_TOLERANCE_HZ = 512.0


def recorded_settings(description: Mapping[str, Any]) -> AnalyzerSettings:
    """Return the settings that the analyzer had when a survey began; empty if not recorded.

    Args:
        description: What the log says of the survey.
    """
    instrument = description.get("instrument")
    sweep = instrument.get("sweep") if isinstance(instrument, dict) else None
    recorded = sweep if isinstance(sweep, dict) else {}
    known = {
        field.name: recorded[field.name]
        for field in dataclasses.fields(AnalyzerSettings)
        if type(recorded.get(field.name)) is type(field.default)
    }
    return AnalyzerSettings(**known)


class PlanFit:
    """Compares traces with the plan of a survey."""

    def __init__(self, description: Mapping[str, Any]) -> None:
        """Compute the plan.

        Args:
            description: What the log says of the survey.

        Raises:
            InvalidValueError: Parameters or axes are missing or not allowed.
        """
        parameters, self._travel = recorded_plan(description)
        self.points: List[SurveyPoint] = survey_points(parameters, self._travel)
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
        """Return the same, but of the frequencies only their number."""
        if trace.index >= len(self.points):
            return [
                Message(
                    "trace {index} was not planned; the plan has {planned} traces",
                    index=trace.index,
                    planned=len(self.points),
                )
            ]
        return [*self._elsewhere(trace), *self._other_number(trace)]

    def _elsewhere(self, trace: Trace) -> List[Message]:
        point, travel = self.points[trace.index], self._travel
        return [
            Message(
                "trace {index} was measured at {axis} {position:g} instead of {planned:g}",
                index=trace.index,
                axis=name,
                position=own,
                planned=planned,
            )
            for name, own, planned, step in (
                ("x", trace.x_coord_mm, point.x_mm, travel.x.step),
                ("y", trace.y_coord_mm, point.y_mm, travel.y.step),
                ("z", trace.z_coord_deg, point.z_deg, travel.z.step),
            )
            # Both are whole motor steps: more than half a step apart is another position.
            if abs(own - planned) > step / 2
        ]

    def _other_number(self, trace: Trace) -> List[Message]:
        if len(trace.frequency_hz) == len(self._frequencies_hz):
            return []
        return [
            Message(
                "trace {index} has {count} frequencies instead of {planned}",
                index=trace.index,
                count=len(trace.frequency_hz),
                planned=len(self._frequencies_hz),
            )
        ]

    def _other_frequencies(self, trace: Trace) -> List[Message]:
        own, planned = trace.frequency_hz, self._frequencies_hz
        wrong = np.abs(own - planned) > FREQUENCY_TOLERANCE_HZ
        if not wrong.any():
            return []
        first = int(np.argmax(wrong))
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
