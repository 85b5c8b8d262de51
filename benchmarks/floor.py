"""How close a survey at the real robot's speed comes to its moves, settling and sweeps alone.

    scripts/bench.sh floor [--workspace DIR --workspace DIR] [--rounds N] [--json FILE]

Launches the simulated robot at its real speed and runs a survey of 20 mm pitch with two rotations
and sweeps of 501 points (0.175 s). From the start of the first sweep to the end of the last, the
measured duration is divided by the sum of the ramps, the settling times and the sweeps.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, List, Sequence

from graph_kit import (
    Sample,
    arguments,
    finish,
    launched,
    median,
    print_table,
    run_survey,
    samples,
    workspaces,
)

from gpr20_survey.axes.ramp import Ramp
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


def measure(root: Path, columns: int, rows: int) -> Floor:
    """Run one survey and compare it with its ideal."""
    with launched(root, "time_scale:=1", f"seconds_per_point:={SECONDS_PER_POINT}") as robot:
        ends = [f"{FIRST_MM + PITCH_MM * (count - 1):g}" for count in (columns, rows)]
        survey = run_survey(
            robot,
            *(f"--x-start-mm={FIRST_MM:g}", f"--x-stop-mm={ends[0]}", f"--x-points={columns}"),
            *(f"--y-start-mm={FIRST_MM:g}", f"--y-stop-mm={ends[1]}", f"--y-points={rows}"),
            *("--polarizations-deg=0,90", f"--frequency-points={POINTS}"),
        )
        return floor_of(survey)


def row(label: str, found: Sequence[Floor]) -> List[str]:
    first = found[0]
    ratio = median([one.ratio for one in found])
    excess_s = median([one.measured_s - one.ideal_s for one in found])
    return [
        label,
        str(first.samples),
        *(f"{one:.1f}" for one in (first.moves_s, first.settling_s, first.sweeps_s)),
        f"{median([one.measured_s for one in found]):.1f}",
        f"{1e3 * excess_s / (first.samples - 1):.0f}",
        f"{ratio:.4f}",
    ]


def main() -> None:
    parser = arguments(__doc__ or "")
    parser.add_argument("--columns", type=int, default=3, help="stops along x (3)")
    parser.add_argument("--rows", type=int, default=3, help="stops along y (3)")
    chosen = parser.parse_args()
    found: Dict[str, List[Floor]] = {}
    for number in range(chosen.rounds):
        for root in workspaces(chosen):
            one = measure(root, chosen.columns, chosen.rows)
            print(f"round {number + 1}: {root}: {one.ratio:.4f}", flush=True)
            found.setdefault(str(root), []).append(one)
    print()
    print_table(
        [
            *("checkout", "samples", "moves s", "settling s", "sweeps s", "measured s"),
            *("beyond ms/sample", "ratio"),
        ],
        [row(label, some) for label, some in found.items()],
    )
    figures = {
        label: [{**asdict(one), "ratio": one.ratio} for one in some]
        for label, some in found.items()
    }
    finish(chosen, {"benchmark": "floor", "figures": figures})


if __name__ == "__main__":
    main()
