"""The form of the plan: what follows from what, its tiles, and the plan of a new robot."""

import math
import random

import pytest
from view_kit import TRAVEL as ROBOT
from view_kit import past_survey, snapshot

from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.fields import PLAN, TILE_FIELDS, VALUE_TILES, default_parameters
from gpr20_operator.plan.form import PlanForm, points_for
from gpr20_operator.plan.presets import PresetContext, areas, spacings
from gpr20_operator.plan.preview import preview, quarter_wavelength_mm
from gpr20_operator.plan.tiles import resumable, spacing_warning, tile_lines, tile_problem
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.imported import IMPORTED
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_parameters import problems
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState

LINEAR = dict(
    dir_pin=13, step_pin=15, sensor_pin=16, step_size=0.01, min_step=0.0015, max_step=0.005,
    delta_step=0.0001, min_coord=0.0, max_coord=650.0, type="LIN",
)  # fmt: skip
ROTARY = {**LINEAR, "step_size": 1.8, "min_step": 0.01, "max_step": 0.025, "delta_step": 0.005}
ROTARY = {**ROTARY, "min_coord": -90.0, "max_coord": 90.0, "sensor_pin": None, "type": "ROT"}


@pytest.fixture
def form():
    return PlanForm(ROBOT)


def test_the_plan_of_a_new_robot_gives_no_warning_and_takes_a_quarter_of_an_hour(form):
    check = form.check()
    known = preview(check.parameters, check.permittivity)
    assert spacing_warning(known) is None
    assert max(known.x_spacing_mm, known.y_spacing_mm) <= known.quarter_wavelength_mm
    axes = {AxisId.X: LINEAR, AxisId.Y: LINEAR, AxisId.Z: ROTARY}
    config = RobotConfig({axis: AxisParameters(**values) for axis, values in axes.items()}, False)
    cost = survey_cost(check.parameters, config, SurveySettings())
    assert 600.0 < cost.duration_s < 900.0


def test_points_follow_the_spacing_and_the_area(form):
    form.set_texts({"x_spacing_mm": "10", "x_start_mm": "0", "x_stop_mm": "300"})
    assert form.texts["x_points"] == "31"
    form.set_text("x_stop_mm", "305")
    assert form.texts["x_points"] == "32"
    form.set_text("x_spacing_mm", "12,5")
    assert form.texts["x_points"] == "26"


def test_points_that_were_set_stay_and_the_spacing_follows(form):
    form.set_text("x_points", "6")
    assert (form.texts["x_spacing_mm"], form.following) == ("20", {"y"})
    form.set_text("x_stop_mm", "350")
    assert (form.texts["x_points"], form.texts["x_spacing_mm"]) == ("6", "60")
    form.set_text("x_spacing_mm", "20")
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


def test_what_is_wrong_is_named_on_its_tile(form):
    for spec in PLAN:
        right = dict(form.texts)
        form.set_text(spec.name, "-7 x5")
        check = form.check()
        (tile,) = (tile for tile in VALUE_TILES if spec.name in TILE_FIELDS[tile])
        assert str(tile_problem(tile, check)).startswith(str(spec.title))
        assert list(check.problems) == [spec.name] and check.parameters is None
        form.restore(right, "xy")


def test_any_text_gives_tiles_and_good_parameters_or_a_problem_on_a_tile():
    draw = random.Random(3)
    texts = ["", "0", "12,5", "-1", "abc", "1e99", "600", "6000", "0;90", "300", "GPIB0::1::INSTR"]
    form = PlanForm(ROBOT)
    for number in range(1200):
        if number % 30 == 0:
            form = PlanForm(ROBOT)
        form.set_text(draw.choice(PLAN).name, draw.choice(texts))
        if draw.random() < 0.3:
            form.arrow(draw.choice(PLAN).name, draw.choice([-10, 1, 100]))
        if draw.random() < 0.2:
            form.normalize()
        check = form.check()
        assert all(len(tile_lines(tile, form.texts, EMPTY)) == 2 for tile in VALUE_TILES)
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


def context(form, last_area=None):
    quarter_mm = quarter_wavelength_mm(form.check().parameters, 4.0)
    return PresetContext(ROBOT, last_area or {}, "", quarter_mm)


def test_the_presets_of_the_area(form):
    whole, centre, origin = areas(context(form))
    assert list(whole.texts.values()) == ["0", "650", "0", "800"]
    assert list(centre.texts.values()) == ["175", "475", "250", "550"]
    assert list(origin.texts.values()) == ["0", "300", "0", "300"]


def test_the_spacing_preset_of_the_soil_is_not_too_coarse(form):
    form.set_texts(spacings(context(form))[-1].texts)
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


def test_the_configured_address_is_proposed_until_another_is_entered(form):
    assert form.propose_address("192.168.1.10")
    assert not form.propose_address("192.168.1.10")
    assert form.propose_address("192.168.1.11")
    form.set_text("vna_address", "10.0.0.7")
    assert not form.propose_address("192.168.1.12")
    assert form.texts["vna_address"] == "10.0.0.7"


def test_only_the_last_survey_is_offered_and_only_if_it_ended_early_and_can_be_resumed():
    idle, early, older = snapshot(SurveyState.IDLE), past_survey(), past_survey(folder="2025")
    complete = past_survey(complete=True)
    imported = past_survey(outcome=IMPORTED, folder="2027")
    for listed, expected in (
        ((), None),
        ((early,), early),
        ((imported, early, older), early),
        ((complete, older), None),
    ):
        past = PastSurveys()
        past.take("", listed, False)
        assert resumable(past, idle) == expected
        for no_robot in (None, snapshot(SurveyState.IDLE, alive=False)):
            assert resumable(past, no_robot) is None
        assert resumable(past, snapshot(SurveyState.SURVEYING)) is None
        past.set_running("another")
        assert resumable(past, idle) is None
