import math
import random

import pytest
from view_kit import TRAVEL as ROBOT

from gpr20_operator.plan.form import (
    PERMITTIVITY,
    PLAN_FIELDS,
    X_SPACING,
    Y_SPACING,
    PlanForm,
)
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.presets import PresetContext, presets_for
from gpr20_operator.plan.preview import preview, quarter_wavelength_mm
from gpr20_operator.plan.spacing import points_for
from gpr20_operator.plan.fields import TILE_FIELDS, VALUE_TILES
from gpr20_operator.plan.spec import Tile
from gpr20_operator.plan.tiles import tile_lines, tile_problem
from gpr20_survey.plan.survey_parameters import problems

ARROWS = [one for one in PLAN_FIELDS if one not in ("vna_address", "polarizations_deg")]


@pytest.fixture
def form():
    return PlanForm(ROBOT)


def test_the_factory_values_can_be_started_and_are_those_of_the_parameters(form):
    check = form.check()
    assert check.problems == {}
    assert check.parameters == default_parameters()
    assert (form.texts[X_SPACING], form.texts["x_points"]) == ("25", "5")


def test_points_follow_the_spacing_and_the_area(form):
    form.set_texts({X_SPACING: "10", "x_start_mm": "0", "x_stop_mm": "300"})
    assert form.texts["x_points"] == "31"
    form.set_text("x_stop_mm", "305")
    assert form.texts["x_points"] == "32"
    form.set_text(X_SPACING, "12,5")
    assert form.texts["x_points"] == "26"


def test_points_that_were_set_stay_and_the_spacing_follows(form):
    form.set_text("x_points", "11")
    assert (form.texts[X_SPACING], form.following) == ("10", {"y"})
    form.set_text("x_stop_mm", "350")
    assert (form.texts["x_points"], form.texts[X_SPACING]) == ("11", "30")
    form.set_text(X_SPACING, "20")
    assert form.texts["x_points"] == "16"


def test_no_two_points_are_farther_apart_than_the_spacing():
    draw = random.Random(1)
    for _ in range(2000):
        spacing_mm, length_mm = draw.uniform(0.5, 60.0), draw.uniform(1.0, 800.0)
        count = points_for(length_mm, spacing_mm)
        assert length_mm / (count - 1) <= spacing_mm * 1.00002
        assert count == 3 or length_mm / (count - 2) > spacing_mm


def test_a_profile_is_measured_as_it_is_whatever_its_spacing():
    draw = random.Random(2)
    for _ in range(40):
        form, other = PlanForm(ROBOT), PlanForm(ROBOT)
        form.set_text("x_start_mm", str(draw.randint(0, 300)))
        form.set_text("x_stop_mm", f"{draw.uniform(301, 650):.2f}")
        form.set_text("x_points", str(draw.randint(3, 400)))
        wanted = form.check().parameters
        other.show_parameters(wanted)
        assert other.check().parameters == wanted
        # The spacing gives the same points again.
        other.set_text("x_stop_mm", other.texts["x_stop_mm"])
        assert other.check().parameters == wanted


def test_what_is_wrong_is_named_on_its_tile_and_locks(form):
    right = dict(form.texts)
    for name, text, words in WRONG:
        form.set_text(name, text)
        check = form.check()
        (tile,) = [one for one in VALUE_TILES if name in TILE_FIELDS[one]]
        assert words in str(tile_problem(tile, check)), (name, text)
        assert (list(check.problems), check.parameters) == ([name], None), text
        form.set_texts(right)


def test_every_field_is_on_one_tile():
    on_tiles = [name for tile in Tile for name in TILE_FIELDS[tile]]
    assert sorted(on_tiles) == sorted(PLAN_FIELDS)


def test_any_text_gives_tiles_and_good_parameters_or_a_problem_on_a_tile():
    draw = random.Random(3)
    texts = ["", "0", "12,5", "-1", "abc", "1e99", "600", "6000", "0;90", "300", "GPIB0::1::INSTR"]
    form = PlanForm(ROBOT)
    for number in range(1200):
        if number % 30 == 0:
            form = PlanForm(ROBOT)
        form.set_text(draw.choice(PLAN_FIELDS), draw.choice(texts))
        if draw.random() < 0.3:
            form.arrow(draw.choice(ARROWS), draw.choice([-10, 1, 100]))
        if draw.random() < 0.2:
            form.normalize()
        check = form.check()
        assert all(len(tile_lines(tile, form.texts)) in (2, 3) for tile in VALUE_TILES)
        wrong = [tile for tile in VALUE_TILES if tile_problem(tile, check) is not None]
        assert (check.parameters is None) == bool(wrong), form.texts
        if check.parameters is not None:
            assert problems(check.parameters, ROBOT) == []


def test_what_was_understood_is_shown(form):
    form.set_texts(
        {"x_start_mm": "12,50", "start_frequency_hz": "600,5", "polarizations_deg": "0;45,0"}
    )
    form.normalize()
    shown = [form.texts[name] for name in ("x_start_mm", "start_frequency_hz", "polarizations_deg")]
    assert shown == ["12.5", "600.5", "0, 45"]


def context(form, last_area=None, address="10.0.0.2"):
    parameters = form.check().parameters
    return PresetContext(ROBOT, last_area or {}, address, quarter_wavelength_mm(parameters, 4.0))


WRONG = (
    ("vna_address", "10.0.0.256", "four whole numbers"),
    *(("start_frequency_hz", text, "from 0.005 to 6000") for text in ("0", "-1")),
    ("start_frequency_hz", "6000", "below the stop frequency"),
    ("stop_frequency_hz", "6000.1", "from 0.005 to 6000"),
    ("stop_frequency_hz", "6GHz", "a number such as 12.5, from 0.005 to 6000"),
    *(("frequency_points", text, "from 2 to 4000") for text in ("0", "1", "4001")),
    *(("x_start_mm", text, "from 0 to 650") for text in ("-1", "inf", "nan", "-inf")),
    *(("x_stop_mm", text, "from 0 to 650") for text in ("650.01", "651")),
    *(("y_start_mm", text, "from 0 to 800") for text in ("nan", "801")),
    ("y_stop_mm", "800,1", "from 0 to 800"),
    ("x_points", "2", "3 or more"),
    ("y_points", "x", "3 or more"),
    ("x_points", "90000", "at least 0.01 mm apart"),
    *((Y_SPACING, text, "above 0") for text in ("0", "-5", "x", "", "1e400")),
    *((PERMITTIVITY, text, "permittivity: from 1 to 81") for text in ("0.9", "82", "wet", "")),
    ("polarizations_deg", "0, 91", "from -90 to 90"),
    ("polarizations_deg", "0, 0", "different"),
    *(("if_bandwidth_hz", text, "as set on the VNA; else 1 to 1e+07") for text in ("0.5", "-10")),
    ("averages", "65536", "a whole number from 1 to 65535"),
    ("output_power", "a b", "the MS2026C has LOW and HIGH"),
)


def test_every_preset_can_be_started(form):
    last = {"x_start_mm": "1", "x_stop_mm": "2", "y_start_mm": "3", "y_stop_mm": "4"}
    for tile in VALUE_TILES:
        for field in TILE_FIELDS[tile]:
            found = presets_for(tile, field, context(form, last))
            assert found
            for preset in found:
                trial = PlanForm(ROBOT)
                trial.set_texts(preset.texts)
                assert trial.check().problems == {}, preset


def test_the_presets_of_the_area(form):
    whole, centre, origin = presets_for(Tile.AREA, "", context(form))
    assert list(whole.texts.values()) == ["0", "650", "0", "800"]
    assert list(centre.texts.values()) == ["175", "475", "250", "550"]
    assert list(origin.texts.values()) == ["0", "300", "0", "300"]


def test_the_spacing_preset_of_the_soil_is_not_too_coarse(form):
    quarter = presets_for(Tile.SPACING, X_SPACING, context(form))[-1]
    form.set_texts(quarter.texts)
    assert not preview(form.check().parameters, 4.0).too_coarse
    assert preview(form.check().parameters, 8.0).too_coarse


def test_quarter_wavelength_and_depth_in_soil():
    # 600 to 6000 MHz: centre 3.3 GHz, 90.85 mm in air.
    air, soil = preview(default_parameters(), 1.0), preview(default_parameters(), 4.0)
    assert math.isclose(air.quarter_wavelength_mm, 22.711, rel_tol=1e-4)
    assert math.isclose(soil.quarter_wavelength_mm, 11.356, rel_tol=1e-4)
    assert math.isclose(air.depth_m, 13.879, rel_tol=1e-4)
    assert math.isclose(soil.depth_m, 6.9396, rel_tol=1e-4)
    assert math.isclose(soil.resolution_m, 0.013879, rel_tol=1e-4)
    assert air.too_coarse and soil.too_coarse  # 25 mm


def test_the_configured_address_is_proposed_until_another_is_entered(form):
    assert form.propose_address("192.168.1.10")
    assert not form.propose_address("192.168.1.10")
    assert form.propose_address("192.168.1.11")
    form.set_text("vna_address", "10.0.0.7")
    assert not form.propose_address("192.168.1.12")
    assert form.texts["vna_address"] == "10.0.0.7"
