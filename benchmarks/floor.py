"""How close a survey at the real robot's speed comes to its moves, settling and sweeps alone.

    scripts/bench.sh floor [--columns 3 --rows 3]

Launches the simulated robot at its real speed and runs a survey of 20 mm pitch with two rotations
and sweeps of 501 points (0.175 s). From the start of the first sweep to the end of the last, the
measured duration is divided by the sum of the ramps, the settling times and the sweeps.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict

from graph_kit import Sample, print_table, run_survey, samples
from robot_kit import simulated_robot

from gpr20_survey.axes import Ramp
from gpr20_survey.plan.survey_parameters import SurveySettings

PITCH_MM = 20.0
POINTS = 501
SECONDS_PER_POINT = 350e-6
FIRST_MM = 100.0


@dataclass(frozen=True)
class Floor:
    """One survey [s]."""

    samples: int
    moves_s: float
    settling_s: float
    sweeps_s: float
    measured_s: float

    @property
    def ideal_s(self) -> float:
        """Nothing but moves, settling and sweeps."""
        return self.moves_s + self.settling_s + self.sweeps_s

    @property
    def ratio(self) -> float:
        """Measured over ideal."""
        return self.measured_s / self.ideal_s


def move_s(axes: Dict[str, Any], before: Sample, after: Sample) -> float:
    """Return how long the slowest axis needs between two samples [s]."""
    times = []
    for axis, distance in (
        ("x", after.x_mm - before.x_mm),
        ("y", after.y_mm - before.y_mm),
        ("z", after.z_deg - before.z_deg),
    ):
        own = axes[axis]
        ramp = Ramp(own["min_step"], own["max_step"], own["delta_step"])
        times.append(ramp.duration_s(round(abs(distance) / own["step_size"])))
    return max(times)


def floor_of(survey: Path) -> Floor:
    """Compare a survey with its ideal."""
    axes = json.loads((survey / "survey.json").read_text())["axes"]
    taken = samples(survey)
    return Floor(
        samples=len(taken),
        moves_s=sum(move_s(axes, *pair) for pair in zip(taken, taken[1:])),
        settling_s=(len(taken) - 1) * SurveySettings().settle_s,
        sweeps_s=len(taken) * POINTS * SECONDS_PER_POINT,
        measured_s=1e-6 * (taken[-1].ended_us - taken[0].started_us),
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--columns", type=int, default=3, help="stops along x (3)")
    parser.add_argument("--rows", type=int, default=3, help="stops along y (3)")
    chosen = parser.parse_args()
    ends = [f"{FIRST_MM + PITCH_MM * (one - 1):g}" for one in (chosen.columns, chosen.rows)]
    with simulated_robot("time_scale:=1", f"seconds_per_point:={SECONDS_PER_POINT}") as robot:
        survey = run_survey(
            robot,
            *(f"--x-start-mm={FIRST_MM:g}", f"--x-stop-mm={ends[0]}"),
            *(f"--y-start-mm={FIRST_MM:g}", f"--y-stop-mm={ends[1]}"),
            *(f"--x-points={chosen.columns}", f"--y-points={chosen.rows}"),
            *("--polarizations-deg=0,90", f"--frequency-points={POINTS}"),
        )
        found = floor_of(survey)
    times_s = (found.moves_s, found.settling_s, found.sweeps_s, found.measured_s)
    beyond_s = (found.measured_s - found.ideal_s) / (found.samples - 1)
    print_table(
        [
            *("samples", "moves s", "settling s", "sweeps s", "measured s"),
            *("beyond ms/sample", "ratio"),
        ],
        [
            [
                str(found.samples),
                *(f"{one:.1f}" for one in times_s),
                f"{1e3 * beyond_s:.0f}",
                f"{found.ratio:.4f}",
            ]
        ],
    )


if __name__ == "__main__":
    main()
