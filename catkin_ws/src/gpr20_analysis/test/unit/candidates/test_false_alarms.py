"""How often clutter is as strong as a candidate, and on how much ground."""

from __future__ import annotations

import numpy as np
import pytest
from echoes_kit import SHAPE, STEP_M, image_of, primary

from gpr20_analysis.candidates.false_alarms import FalseAlarms, surveyed_m2
from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.candidates.table import candidate_lines
from gpr20_analysis.dataset import X, Y
from gpr20_survey.results.candidates import Flag


def test_as_many_false_alarms_are_listed_as_the_density_says():
    counts = [len(primary(find_candidates(image_of([], seed)))) for seed in range(60)]
    area_m2 = surveyed_m2(*(STEP_M * np.arange(count) for count in SHAPE[1:]))
    # Places of 60 mm join some of 10 per m2.
    assert 5.0 < np.mean(counts) / area_m2 < 12.0
    strict = [
        len(primary(find_candidates(image_of([], seed), CandidateOptions(0.1))))
        for seed in range(60)
    ]
    assert np.mean(strict) < 0.2


def test_the_interval_of_the_density_holds_it_in_19_of_20_grounds():
    # 20 dB above is 15 dB / 1.5 dB = 10 slopes above the median of this clutter.
    held = 0
    for seed in range(400):
        random = np.random.default_rng(seed)
        alarms = FalseAlarms(2.0 + random.exponential(1.5, 300), 0.5)
        level_db = 2.0 + 1.5 * np.log(2.0) + 6.0
        lowest, highest = alarms.range_per_m2(level_db)
        held += lowest <= 600.0 * 0.5 * np.exp(-4.0) <= highest
    assert held / 400 > 0.9


def test_of_so_few_echoes_nothing_is_said_about_false_alarms():
    found = find_candidates(image_of([(0, 0.3, 0.3, 0.1, 30.0)], weak=10))
    assert np.isnan(found.false_alarms_per_m2)
    assert all(np.isnan(one.false_alarms_per_m2) for one in found.candidates)
    assert all(Flag.UNRATED in one.flags for one in found.candidates)
    assert len(primary(found)) == 1
    assert any("nothing is known of false alarms" in str(note) for note in found.notes)
    assert not any("of the clutter of this ground" in line for line in candidate_lines(found))


def test_a_narrow_area_and_a_line_see_a_strip_of_the_ground():
    for x_m, y_m, area_m2 in (
        (4.0, 0.0, 1.2), (0.0, 4.0, 1.2), (4.0, 0.02, 1.2), (0.02, 4.0, 1.2), (0.1, 0.1, 0.03),
        (0.5, 0.4, 0.2), (0.0, 0.0, 0.0),
    ):  # fmt: skip
        axes_m = [np.linspace(1.0, 1.0 + side_m, 9) for side_m in (x_m, y_m)]
        assert surveyed_m2(*axes_m) == pytest.approx(area_m2)


@pytest.mark.parametrize("across", [X, Y])
def test_the_extent_of_a_single_line_is_its_length(across):
    image = image_of([(0, 0.3, 0.3, 0.15, 40.0)])
    assert find_candidates(image).length_m is None
    line = find_candidates(image.isel({across: [30]}))
    assert line.length_m == pytest.approx(0.6) and line.area_m2 == pytest.approx(0.18)
    assert any("length: 0.6 m;" in one and "area" not in one for one in candidate_lines(line))
