"""The delay of cables and antennas: fitted, recorded, removed, and noted where it is unseen."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from survey_kit import describe_again, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.permittivity.buried_reference import BuriedReference
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.processing.delay import remove_delay, set_time_zero, to_time
from gpr20_analysis.processing.surface_echo import fit_delay
from gpr20_analysis.read.load import load_survey
from gpr20_simulator.mid.world.scene import Noise

PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(243.7, 236.2, 0.083)
DELAY_S = 0.3e-9
DRAWS = 16


def survey(delay_s=DELAY_S, targets=(TARGET,), height_m=None, **antennas):
    ground = scene(targets, delay_s=delay_s, **antennas)
    return survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,), height_m=height_m)


def depth_m(image):
    strongest = np.abs(image.image).argmax(...)
    return float(image.depth[strongest["depth"]])


def surface_notes(image):
    return [one for one in image.attrs["notes"] if "surface echo" in one]


def test_a_delay_is_fitted_noted_and_corrected():
    measured = survey()
    fit = fit_delay(measured)
    assert abs(fit.delay_s - DELAY_S) < min(10e-12, fit.uncertainty_s)
    cleaned = process_survey(measured, "background")
    fine = tuple(np.arange(0.05, 0.12, 0.0005))
    unseen = image_survey(cleaned, ImageOptions(permittivity=4.0, depth_m=fine))
    seen = image_survey(cleaned, ImageOptions(permittivity=4.0, depth_m=fine, delay_s=fit.delay_s))
    assert abs(depth_m(unseen) - TARGET.depth_m) > 0.02
    assert abs(depth_m(seen) - TARGET.depth_m) <= 1e-3
    (note,) = surface_notes(unseen)
    assert "+45 mm" in note
    assert not surface_notes(seen)
    assert json.loads(seen.attrs["imaging"])["delay_s"] == fit.delay_s


def test_a_buried_reference_is_refused_while_the_surface_is_not_where_it_should_be():
    buried = BuriedReference(0.1, 0.1, 0.1)
    delayed = process_survey(survey(), "background")
    with raises_fault(faults.NO_SURFACE_ECHO, "+45 mm"):
        image_survey(delayed, ImageOptions(buried=buried))
    options = ImageOptions(height_m=0.25, buried=buried)
    with raises_fault(faults.NO_SURFACE_ECHO):
        image_survey(process_survey(survey(0.0), "background"), options)


def test_a_wrong_height_is_noted_beyond_5_mm():
    cleaned = process_survey(survey(0.0), "background")
    for height_m, noted in ((None, 0), (0.203, 0), (0.207, 1)):
        image = image_survey(cleaned, ImageOptions(permittivity=4.0, height_m=height_m))
        assert len(surface_notes(image)) == noted, height_m


def test_the_recorded_delay_is_removed_by_default_and_only_once():
    cleaned = process_survey(survey().assign_attrs(antenna_delay_s=DELAY_S), "background")
    step = process_survey(survey(), f"delay:delay_s={DELAY_S}", "background")
    zero = process_survey(survey().assign_attrs(antenna_delay_s=DELAY_S), "time_zero", "background")
    options = ImageOptions(permittivity=4.0)
    expected = image_survey(process_survey(survey(0.0), "background"), options).image.values
    for one in (cleaned, step):
        image = image_survey(one, options)
        np.testing.assert_allclose(image.image.values, expected, atol=1e-3 * abs(expected).max())
        assert not surface_notes(image)
    assert not surface_notes(image_survey(zero, options))
    with raises_fault(faults.OPTION):
        image_survey(step, replace(options, delay_s=DELAY_S))
    with raises_fault(faults.STEPS):
        remove_delay(step, DELAY_S)
    with raises_fault(faults.STEPS):
        remove_delay(zero, DELAY_S)


def test_the_step_is_a_phase_per_frequency():
    one = survey(0.0)
    expected = one.s21.values * np.exp(2j * np.pi * one.frequency.values * 0.2e-9)
    np.testing.assert_allclose(remove_delay(one, 0.2e-9).s21.values, expected, rtol=1e-12)


def test_time_zero_contains_the_recorded_delay():
    one = survey(coupling_level_db=-200.0).assign_attrs(antenna_delay_s=DELAY_S)
    trace = to_time(set_time_zero(one)).a_scan.values[0, 0, 0]
    assert int(np.argmax(np.abs(trace))) == 0


def test_a_delay_out_of_range_is_refused():
    for delay_s in (float("nan"), 1e-6):
        with raises_fault(faults.OPTION, "-100 and 100 ns"):
            ImageOptions(delay_s=delay_s)
        with raises_fault(faults.OPTION, "-100 and 100 ns"):
            remove_delay(survey(), delay_s)


def random_survey(random):
    """Return a survey of a random scene, its delay and its antenna separation."""
    delay_s = random.choice([0.0, DELAY_S, random.uniform(0.0, 2e-9)])
    separation_m = random.choice([0.0, 0.06, 0.12])
    middle_m, rise_m = random.uniform(0.13, 0.3), random.choice([0.0, 0.02])
    targets = [
        point(*random.uniform(140.0, 340.0, 2), *random.uniform((0.04, 0.02), (0.2, 0.08)))
        for _ in range(random.integers(0, 4))
    ]
    ground = scene(targets, random.uniform(3.0, 9.0), height_m=middle_m, delay_s=delay_s,
                   separation_m=separation_m,
                   coupling_level_db=random.uniform(-50.0, -28.0))  # fmt: skip
    ground = replace(ground, noise=Noise(random.uniform(-90.0, -55.0), int(random.integers(9999))))
    waves = random.uniform(30.0, 90.0, 2)

    def height_m(x_mm, y_mm):
        return middle_m + rise_m * np.sin(x_mm / waves[0]) * np.cos(y_mm / waves[1])

    made = survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,), height_m=height_m)
    sensor_m = random.choice([0.0, 0.003]) * random.standard_normal(made.height.shape)
    return made.assign(height=made.height + sensor_m), delay_s, separation_m


def test_random_scenes_are_fitted_within_the_uncertainty_or_refused():
    within, refused = 0, 0
    for seed in range(DRAWS):
        made, delay_s, separation_m = random_survey(np.random.default_rng(seed))
        try:
            fit = fit_delay(made, separation_m)
        except WrongDatasetError:
            refused += 1
            continue
        within += abs(fit.delay_s - delay_s) <= fit.uncertainty_s
    assert within + refused >= DRAWS - 1
    assert refused <= DRAWS // 6


def test_coupling_far_above_the_surface_is_told_apart_by_differing_heights():
    def height_m(x_mm, y_mm):
        return 0.2 + 0.01 * np.sin(x_mm / 50.0)

    fit = fit_delay(survey(height_m=height_m, coupling_level_db=-5.0))
    assert fit.by_movement
    assert abs(fit.delay_s - DELAY_S) < 10e-12
    # Without that it is refused: the coupling must not be taken for the surface.
    with raises_fault(faults.NO_SURFACE_ECHO):
        fit_delay(survey(coupling_level_db=-5.0))


def test_the_separation_of_the_antennas_is_part_of_the_path():
    apart = survey(separation_m=0.12)
    assert abs(fit_delay(apart, 0.12).delay_s - DELAY_S) < 10e-12
    assert fit_delay(apart).delay_s - DELAY_S > 50e-12


def test_a_method_that_ignores_the_separation_says_so():
    cleaned = process_survey(survey(0.0), "background:method=mean")
    for method, separation_m, noted in (
        (Method.PHASE_SHIFT, 0.12, 1),
        (Method.BACK_PROJECTION, 0.12, 0),
        (Method.PHASE_SHIFT, 0.03, 0),
    ):
        image = image_survey(cleaned, ImageOptions(method, 4.0, separation_m=separation_m))
        notes = [one for one in image.attrs["notes"] if "apart" in one]
        assert len(notes) == noted, (method, separation_m)
        assert all("back-projection" in one for one in notes)


def test_a_metal_plate_at_a_known_height_gives_the_delay():
    plate = survey(targets=(), surface_gain_db=-5.0, height_m=lambda x, y: 0.15)
    wrong = plate.assign(height=plate.height * np.nan)
    few = wrong.isel(y=[0], x=slice(0, 5))
    assert abs(fit_delay(few, height_m=0.15, plate=True).delay_s - DELAY_S) < 10e-12
    with raises_fault(faults.NO_SURFACE_ECHO):
        fit_delay(few, height_m=0.15)
    with raises_fault(faults.NO_SURFACE_ECHO):
        fit_delay(survey(coupling_level_db=-35.0), plate=True)


def noise_alone(seed):
    made, random = survey(targets=()), np.random.default_rng(seed)
    values = random.standard_normal((2, *made.s21.shape))
    return made.assign(s21=(made.s21.dims, values[0] + 1j * values[1]))


def test_noise_has_no_surface():
    for seed in range(10):
        with raises_fault(faults.NO_SURFACE_ECHO):
            fit_delay(noise_alone(seed))


def test_a_removed_background_has_no_surface():
    measured = survey()
    for method in ("mean", "median", "moving", "svd"):
        with raises_fault(faults.NO_SURFACE_ECHO):
            fit_delay(process_survey(measured, f"background:method={method}"))


def test_other_surveys_that_cannot_give_it_are_refused():
    one = survey()
    for fault, wrong in (
        (faults.STEPS, set_time_zero(one)),
        (faults.STEPS, to_time(one)),
        (faults.NO_SURFACE_ECHO, one.isel(frequency=slice(0, 10))),
        (faults.NO_SURFACE_ECHO, one.isel(frequency=[0, 100])),
        (faults.NO_SURFACE_ECHO, one.assign(height=one.height * np.nan)),
        (faults.NO_SURFACE_ECHO, one.assign(s21=one.s21 * 0.0)),
        (faults.NO_SURFACE_ECHO, survey(surface_gain_db=-200.0, targets=())),
    ):
        with raises_fault(fault):
            fit_delay(wrong)


def test_the_robot_configuration_reaches_the_survey(tmp_path):
    folder = make_survey(tmp_path, 18, "finished", more={"analyzer": {"antenna_delay_ns": 0.25}})
    assert load_survey(folder).attrs["antenna_delay_s"] == pytest.approx(0.25e-9)


def change_analyzer(folder, analyzer):
    describe_again(folder, analyzer=analyzer)


def test_surveys_of_earlier_versions_have_none(tmp_path):
    folder = make_survey(tmp_path, 18, None)
    for analyzer in ({}, None, {"address": "127.0.0.1"}, "old"):
        change_analyzer(folder, analyzer)
        assert "antenna_delay_s" not in load_survey(folder).attrs, analyzer


def test_a_delay_that_is_not_valid_is_noted_and_not_used(tmp_path):
    folder = make_survey(tmp_path, 18, None)
    for value in ("0.3", None, True, 1e300, 101.0, [0.3]):
        change_analyzer(folder, {"antenna_delay_ns": value})
        loaded = load_survey(folder)
        assert "antenna_delay_s" not in loaded.attrs, value
        assert any("antenna_delay_ns" in one for one in loaded.attrs["notes"]), value


def test_the_command_prints_the_line_of_the_configuration(tmp_path, capsys):
    path = tmp_path / "survey.nc"
    write_dataset(survey(), path)
    assert main(["delay", str(path)]) == DONE
    key, value = capsys.readouterr().out.splitlines()[-1].split(": ")
    assert key == "antenna_delay_ns"
    assert abs(float(value) - 0.3) < 0.01
    assert main(["image", str(path), "--permittivity", "4"]) == DONE
    assert "gpr20 delay" in capsys.readouterr().out
    assert main(["image", str(path), "--permittivity", "4", "--delay", value]) == DONE
    assert "gpr20 delay" not in capsys.readouterr().out


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(("delay_ns", "noted"), [("0", True), ("0.3", False)])
def test_the_report_shows_the_note(tmp_path, delay_ns, noted):
    path, page = tmp_path / "survey.nc", tmp_path / "report.html"
    write_dataset(survey(), path)
    chosen = ["--permittivity", "4", "--depth", "0", "0.1", "0.01", "--delay", delay_ns]
    assert main(["report", str(path), "-o", str(page), *chosen]) == DONE
    assert ("surface echo is +45 mm" in page.read_text()) == noted


def test_the_command_refuses_processed_data(tmp_path, refusals):
    path = tmp_path / "cleaned.nc"
    write_dataset(process_survey(survey(), "band:start_hz=1e9,stop_hz=6e9"), path)
    assert main(["delay", str(path)]) == REFUSED
    assert refusals[-1:] == [faults.STEPS.code]
    assert main(["delay", str(path), "--separation", "nan"]) == REFUSED
