"""What is a place to check, what is said about it, what comes first, and where the list is cut."""

import numpy as np
import pytest
from echoes_kit import RESOLUTION_M, by_default, image_of, places
from recorded_worlds import BORN, LINES, area, dataset, line, truths
from run_seed import LONG, draws

from gpr20_analysis.candidates.answer import (
    answer,
    field_options,
    focus,
    site_false_alarms_per_m2,
)
from gpr20_analysis.candidates.search import (
    CLUTTER_DB,
    CLUTTER_PER_M2,
    find_candidates,
    least_level_db,
    surveyed_m2,
)
from gpr20_analysis.candidates.table import WEAKER_TITLE, candidate_lines, candidate_table
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import ECHOES, POLARIZATION, X, Y
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Ground
from gpr20_common.catalogue import Language, read_catalogue
from gpr20_survey.results.candidates import NO_CLEARANCE, Flag

STRICT = 0.3


def test_echoes_of_both_polarizations_are_one_candidate_where_they_are():
    for seed in range(draws(3)):
        random = np.random.default_rng(seed)
        place = [float(one) for one in random.uniform(0.08, 0.2, 3)]
        shifted = [one + 0.004 for one in place]
        above_db = random.uniform(31.0, 35.0, 2)
        peaks = [(0, *place, above_db[0]), (1, *shifted, above_db[1])]
        (one,) = places(image_of(peaks, seed), STRICT)
        assert one.id == "C01" and one.flags == () and set(one.rotations_deg) == {0.0, 90.0}
        found = np.array([one.x_m, one.y_m, one.depth_m])
        assert np.abs(found - place).max() < 0.008
        together_db = 10.0 * np.log10(np.sum(10.0 ** (above_db / 10.0)))
        assert one.above_clutter_db == pytest.approx(together_db)
        assert one.polarization_ratio_db == pytest.approx(above_db[0] - above_db[1])
        # No two candidates are nearer than a place.
        listed = find_candidates(image_of(peaks, seed)).candidates
        at = np.array([(other.x_m, other.y_m) for other in listed])
        away_m = np.hypot(*(at[:, None] - at[None]).transpose(2, 0, 1))
        assert away_m[~np.eye(len(at), dtype=bool)].min() > 0.06
    image = image_of([(0, 0.1, 0.1, 0.1, 32.0), (1, 0.4, 0.4, 0.1, 32.0)])
    (one,) = places(image.isel({POLARIZATION: [1]}), STRICT)
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
        (one,) = places(image_of([(0, *place_m, 32.0)]), STRICT)
        assert set(one.flags) == {Flag.ONE_POLARIZATION, *flags}, place_m


def test_echoes_below_each_other_are_one_place_at_the_depth_of_the_brightest():
    peaks = [(0, 0.3, 0.3, 0.08, 38.0), (0, 0.31, 0.3, 0.16, 30.0), (0, 0.33, 0.33, 0.1, 25.0)]
    (one,) = places(image_of(peaks), STRICT)
    assert (one.x_m, one.depth_m) == (0.3, 0.08)


def test_a_wide_body_is_ranked_above_a_narrow_one_that_is_a_little_brighter():
    wide = [(0, 0.3, 0.3, 0.1, 34.0), (0, 0.33, 0.3, 0.1, 33.5), (0, 0.27, 0.3, 0.12, 29.0)]
    narrow = (0, 0.1, 0.1, 0.1, 35.0)
    first, second = places(image_of([*wide, narrow], rotations=(0.0,)), STRICT)
    assert (first.x_m, second.x_m) == (0.3, 0.1)
    # What is itself below the cut, at 30 dB, does not count.
    together_db = 10.0 * np.log10(10.0**3.4 + 10.0**3.35)
    assert first.above_clutter_db == pytest.approx(together_db)
    assert second.above_clutter_db == pytest.approx(35.0)


def test_places_are_ranked_by_strength_above_clutter_whatever_their_flags():
    shown = set()
    for seed in range(draws(50)):
        random = np.random.default_rng(seed)
        peaks = [
            (int(random.integers(2)), *random.uniform(0.0, 0.3, 3), random.uniform(3.0, 40.0))
            for _ in range(int(random.integers(0, 6)))
        ]
        image = image_of(peaks, seed, weak=int(random.integers(1, 400)))
        # The clutter is not equally strong everywhere.
        image[ECHOES][:, 5] += random.uniform(-30.0, 30.0, image.sizes["echo"])
        found = find_candidates(image, float(random.choice([STRICT, 10.0])))
        weak = [one.is_doubtful for one in found.candidates]
        assert weak == sorted(weak)
        for is_weak in (False, True):
            strength = [one.above_clutter_db for one in found.candidates
                        if one.is_doubtful == is_weak and Flag.BRIGHTEST not in one.flags
                        and one.depth_m > 0.006]  # fmt: skip
            assert strength == sorted(strength, reverse=True)
        for one in found.candidates:
            assert one.is_doubtful == bool({Flag.CLUTTER, Flag.SIDELOBE} & {*one.flags})
            assert (
                one.is_doubtful
                or Flag.BRIGHTEST in one.flags
                or (one.above_clutter_db >= found.least_db)
            )
            shown.update(() if one.is_doubtful else one.flags)
    assert {Flag.EDGE, Flag.SURFACE_RESIDUE, Flag.ONE_POLARIZATION, Flag.BRIGHTEST} <= shown


def test_the_brightest_is_never_cut_or_demoted_and_noise_has_none():
    peaks = [(0, 0.3, 0.3, 0.0, 20.0), (0, 0.1, 0.1, 0.15, 18.0), (0, 0.5, 0.5, 0.0, 20.0)]
    image = image_of(peaks, rotations=(0.0,))
    image[ECHOES][0, 5] += 30.0
    first, second = places(image)
    assert (first.x_m, second.x_m) == (0.3, 0.1)  # the other echo of the surface is below the cut
    assert {Flag.EDGE, Flag.SURFACE_RESIDUE} <= {*first.flags}
    image[ECHOES][0, 4] = 5.0
    first, last = places(image)
    assert (first.x_m, last.x_m) == (0.1, 0.3) and Flag.BRIGHTEST in last.flags
    assert not any(Flag.BRIGHTEST in one.flags for one in places(image_of([])))


def test_a_place_34_db_below_one_beside_it_is_one_to_check_and_36_db_below_a_sidelobe():
    peaks = [(0, 0.1, 0.1, 0.15, 70.0), (0, 0.3, 0.3, 0.15, 36.0), (0, 0.3, 0.1, 0.2, 34.0)]
    found = find_candidates(image_of(peaks, rotations=(0.0,)), STRICT)
    assert [one.x_m for one in found.shown()] == [0.1, 0.3]
    third = next(one for one in found.candidates if one.above_clutter_db == 34.0)
    assert third.flags == (Flag.SIDELOBE,) and third.is_doubtful


def test_what_is_below_the_cut_is_one_line_until_somebody_asks():
    found = find_candidates(image_of([(turn, 0.3, 0.3, 0.2, 35.0) for turn in (0, 1)]), STRICT)
    assert len(found.shown()) == 1 and found.weaker > 30 and found.candidates[0].flags == ()
    lines = candidate_lines(found)
    assert [one.split()[0] for one in lines if one.startswith("C")] == ["C01"]
    assert lines[-1].startswith(f"{found.weaker} weaker echoes; show them")
    every = candidate_lines(found, weaker=True)
    assert every.index(str(WEAKER_TITLE)) == lines.index(next(x for x in lines if "C01" in x)) + 1
    assert len([one for one in every if one.startswith("C")]) == len(found.candidates)


def test_lines_say_that_it_is_no_clearance_in_each_language():
    found = find_candidates(image_of([(0, 0.15, 0.15, 0.15, 40.0)], simulated=1), STRICT)
    lines = candidate_lines(found)
    assert lines[0].startswith("SIMULATED") and lines[1] == str(NO_CLEARANCE)
    spanish = candidate_lines(found, read_catalogue(Language.SPANISH))
    assert spanish[0].startswith("SIMULADO") and "despeje" in spanish[1]
    empty = candidate_lines(find_candidates(image_of([], weak=0)))
    assert str(NO_CLEARANCE) in empty and any("check: 0 " in one for one in empty)


@pytest.mark.parametrize(("lowest", "highest"), [(3.6, 4.4), (3.0, 6.0)])
def test_the_depth_has_the_uncertainty_of_permittivity_height_and_band(lowest, highest):
    # 10 % of a permittivity that was given.
    known = {"permittivity_lowest": lowest, "permittivity_highest": highest} if lowest < 3.5 else {}
    (one,) = places(image_of([(0, 0.15, 0.15, 0.2, 40.0)], **known), STRICT)
    of_permittivity_m = 0.2 * max((4.0 / lowest) ** 0.5 - 1.0, 1.0 - (4.0 / highest) ** 0.5)
    assert one.depth_uncertainty_m == pytest.approx(
        np.hypot(0.0015, RESOLUTION_M / 4.0) + of_permittivity_m, rel=0.01
    )
    assert 0.01 < one.x_uncertainty_m < 0.02


def test_a_lower_rate_of_false_alarms_cuts_the_list_higher():
    assert [least_level_db(one) for one in CLUTTER_PER_M2] == pytest.approx(CLUTTER_DB)
    assert least_level_db(10.0, 100.0) == pytest.approx(least_level_db(10.0) - 6.5)
    # What was not scored moves the cut no further.
    assert least_level_db(10.0, 1e5) == least_level_db(10.0, 2500.0) < 15.0
    random = np.random.default_rng(1)
    for low, high in np.sort(random.uniform(0.3, 20.0, (50, 2)), axis=1):
        assert least_level_db(low) >= least_level_db(high)
    image = image_of([(0, 0.1 * at, 0.3, 0.15, 8.0 + 3.0 * at) for at in range(1, 6)])
    counts = [len(places(image, one)) for one in (20.0, 10.0, 6.0, 3.0, 0.3)]
    assert counts == sorted(counts, reverse=True) and counts[0] > counts[-1]


def test_the_rate_is_that_of_the_site_unless_somebody_gives_another():
    survey, truth = line(2)
    own = survey.assign_attrs(survey_json='{"site": {"false_alarms_per_m2": 3.0}}')
    for wrong in ('{"site": {"false_alarms_per_m2": 1e9}}', '{"site": 1}', "damaged"):
        assert site_false_alarms_per_m2(survey.assign_attrs(survey_json=wrong)) == 10.0
    options = {"permittivity": truth["permittivity"], "ground": Ground.LEVEL}
    for data, more, rate in ((survey, {}, 10.0), (own, {}, 3.0),
                             (own, {"false_alarms_per_m2": 5.0}, 5.0)):  # fmt: skip
        found = answer(data, ImageOptions(**options, **more)).found
        assert found.false_alarms_per_m2 == rate
        assert found.least_db == pytest.approx(least_level_db(rate), abs=1.0)
    for wrong in (0.1, 21.0, float("nan"), "5", True):
        with pytest.raises(WrongDatasetError):
            ImageOptions(false_alarms_per_m2=wrong)


@pytest.mark.parametrize("across", [X, Y])
def test_a_line_has_a_length_and_no_empty_columns(across):
    image = image_of([(0, 0.3, 0.3, 0.15, 40.0)], rotations=(0.0,))
    assert find_candidates(image).length_m is None
    found = find_candidates(image.isel({across: [30]}).assign_attrs(across_lines=across))
    assert found.length_m == pytest.approx(0.6) and found.area_m2 == pytest.approx(0.18)
    heading = candidate_table(found, found.shown())[0]
    assert f"{across} mm" not in heading and "depth mm" in heading and len(heading) == 6
    for x_m, y_m, area_m2 in (
        *((4.0, 0.0, 1.2), (0.0, 4.0, 1.2), (0.02, 4.0, 1.2), (0.1, 0.1, 0.03)),
        *((0.5, 0.4, 0.2), (0.0, 0.0, 0.0)),
    ):
        axes_m = [np.linspace(1.0, 1.0 + side_m, 9) for side_m in (x_m, y_m)]
        assert surveyed_m2(*axes_m) == pytest.approx(area_m2)
    assert any("length 0.6 m" in one and "area" not in one for one in candidate_lines(found))


def density(lists):
    return sum(one.primary for one in lists) / sum(one.area_m2 for one in lists)


def random_noise(seed):
    """Return a survey of random size, band and height that has white noise alone."""
    random = np.random.default_rng(seed)
    columns, rows = int(random.integers(8, 50)), int(random.choice([1, random.integers(8, 40)]))
    step_m = float(random.choice([0.01, 0.015, 0.02]))
    start_hz, stop_hz = random.choice([0.6e9, 1e9]), random.choice([3e9, 6e9])
    frequency_hz = np.linspace(start_hz, stop_hz, int(random.choice([51, 101, 201])))
    height_m = np.full((rows, columns), random.uniform(0.05, 0.3))
    parts = random.standard_normal((rows, columns, len(frequency_hz), 2)) / np.sqrt(2.0)
    x_m, y_m = step_m * np.arange(columns), step_m * np.arange(rows)
    return dataset(parts @ np.array([1.0, 1j]), height_m, x_m, y_m, frequency_hz)


def test_noise_has_at_most_one_place_per_m2_and_ground_without_bodies_about_the_rate():
    noise = [random_noise(seed) for seed in range(draws(15))]
    lists = [answer(one, ImageOptions(permittivity=5.0)).found for one in noise
             if max(one.sizes[X], one.sizes[Y]) > 20]  # fmt: skip
    assert density(lists) <= 1.0
    # Every second one set the rate; these are the others.
    empty = [at for at, truth in enumerate(truths(LINES)) if not truth["bodies"] and at % 2]
    lists = []
    for number in empty[:: 1 if LONG else 3]:
        survey, truth = line(number)
        lists.append(find_candidates(by_default(survey, truth["permittivity"])))
    assert 5.0 < density(lists) < 17.0


def test_mines_beside_fragments_that_outshine_them_are_among_the_first_three():
    scenes = [at for at, truth in enumerate(truths(BORN)) if len(truth["bodies"]) > 1]
    for number in scenes[:: 1 if LONG else 3]:
        survey, truth = area(BORN, number)
        shown = places(by_default(survey, truth["permittivity"]))
        for body in truth["bodies"]:
            away_m = [np.hypot(one.x_m - body["x_m"], one.y_m - body["y_m"]) for one in shown[:3]]
            assert min(away_m) < 0.03 + body["size_m"][0] / 2.0, number


MORE = [(30, 3), (3, 40), (1, 5), (2, 2)]
SHAPES = [(1, 40), (30, 1), (1, 2), *(pytest.param(*s, marks=pytest.mark.release) for s in MORE)]


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
def test_the_default_command_images_every_shape(tmp_path, capsys, rows, columns):
    survey = next(
        one
        for one in (random_noise(seed) for seed in range(100))
        if one.sizes[Y] >= rows and one.sizes[X] >= columns
    )
    path = tmp_path / "survey.nc"
    write_dataset(survey.isel(y=slice(rows), x=slice(columns)), path)
    assert main(["image", str(path), "--permittivity", "5"]) == 0
    text = capsys.readouterr().out
    assert "Places to check:" in text and ("length" in text) == (1 in (rows, columns))


def test_window_and_command_have_one_answer(tmp_path, capsys):
    survey, truth = area(BORN, 3)
    path = tmp_path / "survey.nc"
    write_dataset(survey, path)
    soil = truth["permittivity"]
    by_window = focus(survey, soil).found
    command = ["candidates", str(path), "--permittivity", str(soil), "--leave-out-missing"]
    assert main([*command, "--weaker"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [one for one in printed if one in candidate_lines(by_window, weaker=True)]
    assert answer(survey, field_options(soil, survey)).found == by_window
