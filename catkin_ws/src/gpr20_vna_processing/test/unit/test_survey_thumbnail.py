"""The small map of a listed survey, and that a list is not made again for nothing."""

import os

import numpy as np

from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.results.survey_summary import NO_THUMBNAIL
from gpr20_vna_processing.mid.recent_summaries import SETTLED_NS, RecentSummaries
from gpr20_vna_processing.mid.survey_thumbnail import MOST_CELLS, thumbnail_of

TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


def parameters(generator):
    x_mm, y_mm = (generator.choice([10.0, 310.0], 2, replace=False) for _ in range(2))
    points = generator.integers(3, 60, 2)
    return {
        **{"vna_address": "", "start_frequency_hz": 6e8, "stop_frequency_hz": 6e9},
        **{"frequency_points": 5, "x_points": int(points[0]), "y_points": int(points[1])},
        **{"x_start_mm": float(x_mm[0]), "x_stop_mm": float(x_mm[1])},
        **{"y_start_mm": float(y_mm[0]), "y_stop_mm": float(y_mm[1])},
        "polarizations_deg": [0.0, 90.0][: int(generator.integers(1, 3))],
    }


def test_every_stored_trace_counts_where_it_was_measured():
    for seed in range(12):
        check_thumbnail(seed)


def check_thumbnail(seed):
    generator = np.random.default_rng(seed)
    values = parameters(generator)
    points = survey_points(SurveyParameters(**values), TRAVEL)
    stored = sorted(generator.choice(len(points), generator.integers(0, len(points) + 1), False))
    found = thumbnail_of(values, [int(one) for one in stored])
    assert (found.width_mm, found.height_mm) == (300.0, 300.0)
    assert (found.columns, found.rows) == tuple(
        min(values[f"{axis}_points"], MOST_CELLS) for axis in "xy"
    )
    kept, planned = (np.zeros((found.rows, found.columns)) for _ in range(2))
    for point in points:
        row, column = (
            round((at_mm - 10.0) / 300.0 * (count - 1)) * cells // count
            for at_mm, count, cells in (
                (point.y_mm, values["y_points"], found.rows),
                (point.x_mm, values["x_points"], found.columns),
            )
        )
        planned[row, column] += 1
        kept[row, column] += point.index in stored
    percent = np.frombuffer(found.percent, np.uint8).reshape(found.rows, found.columns)
    assert np.array_equal(percent == 100, kept == planned)
    assert np.array_equal(percent == 0, kept == 0)
    assert np.all(np.abs(percent - 100.0 * kept / planned) < 1.0 + (kept > 0))


def test_impossible_counts_make_no_map():
    for wrong in (
        *({"x_points": 10**9}, {"y_points": "3"}, {"polarizations_deg": 2}, {"x_points": True}),
    ):
        found = thumbnail_of({**parameters(np.random.default_rng(0)), **wrong}, [0])
        assert (found.columns, found.percent) == (0, b""), wrong


def test_unreadable_parameters_make_no_thumbnail():
    whole = parameters(np.random.default_rng(0))
    for wrong in (None, [], {}, {**whole, "x_start_mm": float("nan")}):
        assert thumbnail_of(wrong, [0]) == NO_THUMBNAIL, wrong


def test_a_summary_is_made_again_only_after_a_change(tmp_path):
    folder = tmp_path / "survey"
    (folder / "traces").mkdir(parents=True)
    (folder / "survey.json").write_text("{}")
    made = []
    now = [os.stat(str(folder)).st_mtime_ns]

    def make(path):
        made.append(path)
        return len(made)

    summaries = RecentSummaries(make, lambda: now[0])
    # Just changed: another change might not show.
    assert [summaries.of(folder), summaries.of(folder)] == [1, 2]
    now[0] += 2 * SETTLED_NS
    assert [summaries.of(folder) for _ in range(3)] == [3, 3, 3]
    (folder / "traces" / "000000.json").write_text("{}")
    os.utime(str(folder / "traces"), ns=(0, now[0]))
    assert summaries.of(folder) == 4
    (folder / "survey.json").unlink()
    assert [summaries.of(folder), summaries.of(folder)] == [5, 6]
