"""How long a survey takes and how much room it needs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from typing import Callable, List, Sequence

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_plan import SurveyPoint

# What the robot's group states for this instrument; a longer sweep only makes the
# estimate before the first trace too short.
SECONDS_PER_FREQUENCY = 350.0e-6
# A JSON file holds three numbers of up to 24 characters per frequency, each recording
# three doubles; the two recordings hardly compress noise.
BYTES_PER_FREQUENCY = 3 * 24 + 2 * 3 * 8
BYTES_PER_TRACE = 4096
# Positions at up to 150 messages per second and everything else, in both recordings.
RECORDED_BYTES_PER_S = 40_000

MoveDuration = Callable[[AxisId, float], float]


@dataclass(frozen=True)
class MeasuringTimes:
    """Time spent at each point beside the move: settling, and sweep or height [s]."""

    settle_s: float
    height_s: float
    frequency_points: int

    @property
    def total_s(self) -> float:
        """Time at one point [s]; sweep and height are measured together."""
        sweep_s = SECONDS_PER_FREQUENCY * self.frequency_points
        return self.settle_s + max(sweep_s, self.height_s)


def point_durations_s(
    points: Sequence[SurveyPoint], move_duration_s: MoveDuration, times: MeasuringTimes
) -> List[float]:
    """Return how long each point takes [s]: the move to it and the measurement there.

    The way to the first point begins at the zero of the axes.
    """
    durations = []
    before = SurveyPoint(-1, 0.0, 0.0, 0.0)
    for point in points:
        move_s = max(
            move_duration_s(AxisId.X, point.x_mm - before.x_mm),
            move_duration_s(AxisId.Y, point.y_mm - before.y_mm),
            move_duration_s(AxisId.Z, point.z_deg - before.z_deg),
        )
        durations.append(move_s + times.total_s)
        before = point
    return durations


def needed_bytes(traces: int, frequency_points: int, duration_s: float) -> int:
    """Return an estimate of the size of a survey on disk [bytes], rather too large."""
    per_trace = BYTES_PER_FREQUENCY * frequency_points + BYTES_PER_TRACE
    return traces * per_trace + int(duration_s * RECORDED_BYTES_PER_S)


class RemainingTime:
    """Time to the end of a survey, from the plan and from the pace so far."""

    def __init__(self, durations_s: Sequence[float]) -> None:
        self._planned_s = [0.0, *accumulate(durations_s)]

    @property
    def planned_s(self) -> float:
        """Time that the whole plan takes [s]."""
        return self._planned_s[-1]

    def remaining_s(self, points_done: int, elapsed_s: float) -> float:
        """Return the time to the end [s].

        The rest of the plan is stretched by how much longer than planned the points so
        far have taken.

        Args:
            points_done: Points that are finished, in the order of the plan.
            elapsed_s: Time spent on them [s], pauses left out.
        """
        done_s = self._planned_s[points_done]
        rest_s = self.planned_s - done_s
        return rest_s * (elapsed_s / done_s) if done_s > 0.0 else rest_s
