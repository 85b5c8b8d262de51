"""What is a candidate, what is said about it, and what comes first in the list."""

from dataclasses import replace

import numpy as np
import pytest
from echoes_kit import RESOLUTION_M, SHAPE, STEP_M, STRICT, by_default, image_of, primary
from fault_kit import raises_fault
from random_scenes_kit import Clutter, random_noise
from recorded_worlds import LINES, line, truths
from run_seed import LONG, draws

from gpr20_analysis.candidates.false_alarms import FalseAlarms, surveyed_m2
from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.candidates.table import (
    DOUBTFUL_TITLE,
    candidate_lines,
)
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import ECHOES, POLARIZATION, X, Y
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.processing.chain import process_survey
from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.results.candidates import NO_CLEARANCE, Flag


def test_echoes_of_both_polarizations_are_one_candidate_where_they_are():
    for seed in range(draws(3)):
        random = np.random.default_rng(seed)
        place = [float(one) for one in random.uniform(0.08, 0.2, 3)]
        shifted = [one + 0.004 for one in place]
        above_db = random.uniform(25.0, 35.0, 2)
        peaks = [(0, *place, above_db[0]), (1, *shifted, above_db[1])]
        (one,) = primary(find_candidates(image_of(peaks, seed), STRICT))
        assert one.id == "C01" and one.flags == () and set(one.rotations_deg) == {0.0, 90.0}
        found = np.array([one.x_m, one.y_m, one.depth_m])
        assert np.abs(found - place).max() < 0.008
        assert one.above_clutter_db == max(above_db)
        assert one.polarization_ratio_db == pytest.approx(above_db[0] - above_db[1])
        assert one.false_alarms_per_m2 < 0.1
        # No two candidates are nearer than a place.
        listed = find_candidates(image_of(peaks, seed)).candidates
        places = np.array([(other.x_m, other.y_m) for other in listed])
        away_m = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        assert away_m[~np.eye(len(places), dtype=bool)].min() > 0.06
    for wrong in ({"false_alarms_per_m2": np.nan}, {"most": 0}):
        with pytest.raises(WrongDatasetError):
            CandidateOptions(**wrong)
    image = image_of([(0, 0.1, 0.1, 0.1, 30.0), (1, 0.4, 0.4, 0.1, 30.0)])
    (one,) = primary(find_candidates(image.isel({POLARIZATION: [1]}), STRICT))
    assert one.x_m == 0.4 and one.rotations_deg == (90.0,) and one.flags == ()
    with pytest.raises(WrongDatasetError, match="make it again"):
        find_candidates(image.drop_vars(ECHOES))


def test_what_to_know_about_a_candidate_is_flagged():
    for place_m, flags in (
        ((0.15, 0.15, 0.15), set()),
        ((0.005, 0.15, 0.15), {Flag.EDGE}),
        ((0.15, 0.15, 0.30), {Flag.EDGE}),
        ((0.15, 0.15, 0.02), {Flag.SURFACE_RESIDUE}),
    ):
        (one,) = primary(find_candidates(image_of([(0, *place_m, 30.0)]), STRICT))
        assert set(one.flags) == {Flag.ONE_POLARIZATION, *flags}, place_m


def test_echoes_below_each_other_are_one_place_at_the_depth_of_the_brightest():
    peaks = [(0, 0.3, 0.3, 0.08, 38.0), (0, 0.31, 0.3, 0.16, 30.0), (0, 0.33, 0.33, 0.1, 25.0)]
    (one,) = primary(find_candidates(image_of(peaks), STRICT))
    assert (one.x_m, one.depth_m) == (0.3, 0.08)


def test_what_may_be_the_surface_comes_after_the_others_unless_it_is_the_brightest():
    peaks = [
        (0, 0.1, 0.1, 0.01, 60.0),
        (0, 0.3, 0.3, 0.15, 40.0),
        (0, 0.5, 0.1, 0.2, 30.0),
    ]
    # The third is brighter, in stronger clutter.
    for louder_db, order in ((15.0, [0.1, 0.3, 0.5]), (35.0, [0.5, 0.3, 0.1])):
        image = image_of(peaks, rotations=(0.0,))
        image[ECHOES][2, 5] += louder_db
        found = primary(find_candidates(image, STRICT))
        assert [one.x_m for one in found] == order
        residue = next(one for one in found if one.x_m == 0.1)
        assert Flag.SURFACE_RESIDUE in residue.flags


def test_the_brightest_echo_is_first_whatever_its_flags_and_its_flags_stay():
    flags = set()
    for seed in range(draws(50)):
        random = np.random.default_rng(seed)
        count = int(random.integers(0, 6))
        peaks = [
            (int(random.integers(2)), *random.uniform(0.0, 0.3, 3), random.uniform(3.0, 40.0))
            for _ in range(count)
        ]
        image = image_of(peaks, seed, weak=int(random.integers(1, 400)))
        # The clutter is not equally strong everywhere.
        image[ECHOES][:, 5] += random.uniform(-30.0, 30.0, image.sizes["echo"])
        options = CandidateOptions(
            float(random.choice([0.1, 10.0])), most=int(random.integers(1, 9))
        )
        found = find_candidates(image, options)
        rows = image[ECHOES].values
        brightest = rows[np.argmax(rows[:, 5])]
        first = found.candidates[0]
        # One place reaches 60 mm from its echo, which is as far from the one that it began with.
        assert np.hypot(first.x_m - brightest[3], first.y_m - brightest[2]) <= 0.12
        assert first.id == "C01" and found.shown()[0] is first
        assert (Flag.CLUTTER in first.flags) == (
            first in [one for one in found.candidates if one.is_doubtful]
        )
        # Nobody who looks for those that are not doubtful misses one.
        everything = find_candidates(image, replace(options, most=10_000))
        assert len(primary(found)) + found.omitted_primary == len(primary(everything))
        assert found.omitted_primary == 0 or Flag.UNRATED in first.flags
        # Only doubtful ones are left out of a list that is too long, and they come last.
        later = [one.is_doubtful for one in found.candidates[1:]]
        assert later == sorted(later)
        flags.update(first.flags)
    assert {Flag.CLUTTER, Flag.SURFACE_RESIDUE, Flag.UNRATED, Flag.EDGE} <= flags


def test_a_body_35_db_below_one_beside_it_is_no_sidelobe_but_one_41_db_below_may_be():
    peaks = [
        (0, 0.1, 0.1, 0.15, 70.0),
        (0, 0.3, 0.3, 0.15, 35.0),
        (0, 0.3, 0.1, 0.2, 29.0),
    ]
    found = find_candidates(image_of(peaks, rotations=(0.0,)), STRICT)
    assert [one.x_m for one in primary(found)] == [0.1, 0.3]
    third = next(one for one in found.candidates if one.above_clutter_db == 29.0)
    assert third.flags == (Flag.SIDELOBE,) and third.is_doubtful


def test_doubtful_ones_are_counted_where_they_are_not_shown():
    peaks = [(turn, 0.3, 0.3, 0.2, 35.0) for turn in (0, 1)]
    found = find_candidates(image_of(peaks), CandidateOptions(0.1, most=5))
    first, *others = found.candidates
    assert first.flags == () and all(Flag.CLUTTER in one.flags for one in others)
    assert found.omitted > 10 and found.omitted_primary == 0
    everything = find_candidates(image_of(peaks), CandidateOptions(0.1, most=10_000))
    assert len(everything.candidates) == found.omitted + 5 and everything.omitted == 0
    shown = everything.shown()
    assert shown == everything.candidates[:11] and not shown[0].is_doubtful
    lines = candidate_lines(everything)
    assert lines[3] == str(DOUBTFUL_TITLE) and len(lines) == 3 + 11 + 4
    assert f"--most {len(everything.candidates)}" in lines[-1]
    assert not any("--most" in one for one in candidate_lines(everything, most_doubtful=None))


def test_lines_say_that_it_is_no_clearance_in_each_language():
    found = find_candidates(image_of([(0, 0.15, 0.15, 0.15, 40.0)], simulated=1), STRICT)
    lines = candidate_lines(found)
    assert lines[0].startswith("SIMULATED") and lines[1] == str(NO_CLEARANCE)
    spanish = candidate_lines(found, read_catalogue(Language.SPANISH))
    assert spanish[0].startswith("SIMULADO") and "despeje" in spanish[1]
    empty = candidate_lines(find_candidates(image_of([], weak=0)))
    assert str(NO_CLEARANCE) in empty and "No candidate was found." in empty


@pytest.mark.parametrize(("lowest", "highest"), [(3.6, 4.4), (3.0, 6.0)])
def test_the_depth_has_the_uncertainty_of_permittivity_height_and_band(lowest, highest):
    # 10 % of a permittivity that was given.
    known = {"permittivity_lowest": lowest, "permittivity_highest": highest} if lowest < 3.5 else {}
    image = image_of([(0, 0.15, 0.15, 0.2, 40.0)], **known)
    (one,) = primary(find_candidates(image, replace(STRICT, height_uncertainty_m=0.004)))
    of_permittivity_m = 0.2 * max((4.0 / lowest) ** 0.5 - 1.0, 1.0 - (4.0 / highest) ** 0.5)
    assert one.depth_uncertainty_m == pytest.approx(
        np.hypot(0.002, RESOLUTION_M / 4.0) + of_permittivity_m, rel=0.01
    )
    assert 0.01 < one.x_uncertainty_m < 0.02


def test_as_many_false_alarms_are_listed_as_the_density_says():
    seeds = range(draws(15))
    counts = [len(primary(find_candidates(image_of([], seed)))) for seed in seeds]
    area_m2 = surveyed_m2(*(STEP_M * np.arange(count) for count in SHAPE[1:]))
    # Places of 60 mm join some of 10 per m2.
    assert 5.0 < np.mean(counts) / area_m2 < 12.0
    strict = [
        len(primary(find_candidates(image_of([], seed), CandidateOptions(0.1)))) for seed in seeds
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
    assert found.false_alarms_per_m2 is None
    assert all(one.false_alarms_per_m2 is None for one in found.candidates)
    assert all(Flag.UNRATED in one.flags for one in found.candidates)
    assert len(primary(found)) == 1
    assert any("nothing is known of false alarms" in str(note) for note in found.notes)
    assert not any("of the clutter of this ground" in line for line in candidate_lines(found))


@pytest.mark.parametrize("across", [X, Y])
def test_the_extent_of_a_single_line_is_its_length(across):
    image = image_of([(0, 0.3, 0.3, 0.15, 40.0)])
    assert find_candidates(image).length_m is None
    line = find_candidates(image.isel({across: [30]}))
    assert line.length_m == pytest.approx(0.6) and line.area_m2 == pytest.approx(0.18)
    # A narrow area and a line see a strip of the ground.
    for x_m, y_m, area_m2 in (
        *((4.0, 0.0, 1.2), (0.0, 4.0, 1.2), (0.02, 4.0, 1.2), (0.1, 0.1, 0.03)),
        *((0.5, 0.4, 0.2), (0.0, 0.0, 0.0)),
    ):
        axes_m = [np.linspace(1.0, 1.0 + side_m, 9) for side_m in (x_m, y_m)]
        assert surveyed_m2(*axes_m) == pytest.approx(area_m2)
    assert any("length: 0.6 m;" in one and "area" not in one for one in candidate_lines(line))


ASKED_PER_M2 = 10.0
RELEASE = pytest.mark.release
MORE = [(5, 5), (30, 3), (3, 40), (1, 5), (5, 1), (2, 2), (2, 1)]
SHAPES = [(1, 40), (30, 1), (1, 2), *(pytest.param(*one, marks=RELEASE) for one in MORE)]


def found_in(survey, permittivity=5.0):
    return find_candidates(by_default(survey, permittivity))


def density(lists):
    """Return candidates per m2 that are not doubtful, of the lists that say how many to expect."""
    rated = [one for one in lists if one.false_alarms_per_m2 is not None]
    assert len(rated) > 5
    return sum(one.primary for one in rated) / sum(one.area_m2 for one in rated)


@pytest.mark.parametrize("kind", [Clutter.WHITE, Clutter.SURFACE])
@pytest.mark.parametrize(
    ("rows", "columns"),
    [(3, 100), *(pytest.param(*one, marks=RELEASE) for one in ((100, 100), (100, 3), (1, 100)))],
)
def test_of_noise_and_of_a_rough_surface(kind, rows, columns):
    lists = []
    for seed in range(draws(15)):
        survey = random_noise(seed, kind).isel(y=slice(rows), x=slice(columns))
        if (survey.sizes[Y] == 1) == (rows == 1) and max(survey.sizes[X], survey.sizes[Y]) > 20:
            lists.append(found_in(survey))
    # Noise alone falls off otherwise than the clutter of ground.
    assert density(lists) < 2.5 * ASKED_PER_M2


def test_of_computed_lines():
    lists = []
    empty = [number for number, truth in enumerate(truths(LINES)) if not truth["bodies"]]
    assert len(empty) == 53
    for number in empty[:: 1 if LONG else 4]:
        survey, truth = line(number)
        lists.append(found_in(survey, truth["permittivity"]))
    least, most = (0.5, 1.3) if LONG else (0.3, 1.6)
    assert least * ASKED_PER_M2 < density(lists) < most * ASKED_PER_M2


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
def test_the_default_command_images_every_shape(tmp_path, capsys, rows, columns):
    survey = next(
        one
        for one in (random_noise(seed, Clutter.WHITE) for seed in range(100))
        if one.sizes[Y] >= rows and one.sizes[X] >= columns
    )
    path = tmp_path / "survey.nc"
    write_dataset(survey.isel(y=slice(rows), x=slice(columns)), path)
    assert main(["image", str(path), "--permittivity", "5"]) == 0
    text = capsys.readouterr().out
    assert "C01" in text or "No candidate was found." in text
    assert ("length:" in text) == (1 in (rows, columns)) != ("area:" in text)


@pytest.mark.parametrize(
    "ground", ["cluttered", pytest.param("rough, cluttered and lossy", marks=RELEASE)]
)
def test_clean_ground_of_the_site_gives_no_smaller_density_than_there_is(ground):
    images = [
        by_default(line(number)[0])
        for number, truth in enumerate(truths(LINES))
        if truth["ground"] == ground and not truth["bodies"]
    ]
    # Each by another line of such ground.
    lists = [
        find_candidates(image, clean_ground=images[place - 1]) for place, image in enumerate(images)
    ]
    assert len(lists) >= 10
    assert all("clean ground" in str(one.notes[-1]) for one in lists)
    assert 2.0 < density(lists) < 1.2 * ASKED_PER_M2


def test_clean_ground_that_was_imaged_in_another_way_is_refused(tmp_path, capsys):
    survey = process_survey(line(0)[0], *DEFAULT_STEPS)
    image = image_survey(survey, ImageOptions(permittivity=5.0))
    other = image_survey(survey, ImageOptions(permittivity=16.0))
    for clean in (other, image.assign_attrs(method="back-projection")):
        with raises_fault(NOT_ALLOWED):
            find_candidates(image, clean_ground=clean)
    write_dataset(survey, tmp_path / "survey.nc")
    write_dataset(image, tmp_path / "clean.nc")
    paths = [str(tmp_path / "survey.nc"), "--permittivity", "5", "--clean-ground"]
    assert main(["candidates", *paths, str(tmp_path / "clean.nc")]) == DONE
    assert "clean ground" in capsys.readouterr().out
    assert main(["candidates", *paths, str(tmp_path / "survey.nc")]) == REFUSED
