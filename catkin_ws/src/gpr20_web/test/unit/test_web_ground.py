"""GROUND for browsers: the pictures are those of the window, and none shows a wrong one."""

from dataclasses import replace

import pytest
from case_kit import each_case
from map_kit import MARKER, focused, marked
from result_kit import TIME_US, noted, stored
from view_kit import depth_echo, description, past_survey, state_of, trace_at
from web_ground_kit import FOLDER, PERIOD_S, SURVEY, Server

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import Place
from gpr20_operator.ground.sources import Axis, EchoSource, RadarSettings
from gpr20_operator.ground.traces import RETRY_S, SurveyDescribed
from gpr20_operator.jobs.pictures import SurveysListed
from gpr20_operator.palette import Theme, pattern, pattern_colours, shade_colours, shade_numbers
from gpr20_operator.robot.events import Progress
from gpr20_survey.folder.log_record import soil_values
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.faults import BusyError, NotFoundError
from gpr20_web.mid.ground_page import FORGOTTEN_S, MOST_PAST, ROOM_S
from gpr20_web.mid.shown_ground import AGAIN_S, PATTERN_PX

TARGETED = Place(150.0, 90.0)


@pytest.fixture
def server():
    return Server()


def radar_of(server):
    return server.page._live.traces.live.radar


@pytest.mark.parametrize("along", ["x", "y"])
def test_map_and_section_have_the_colours_of_the_window(server, along):
    grid = server.run(permittivity=6.0)
    # No row is like another one: nothing may be upside down.
    for index in range(grid.planned):
        level = 10.0 ** (-index / 40.0)
        server.page.on_event(trace_at(grid, index, s21=depth_echo(0.1, level=level)))
    server.tick()
    source, colours = EchoSource(radar_of(server)), shade_colours()
    picture = source.slice(RadarSettings(depth_m=0.1, permittivity=6.0))
    expected = colours[shade_numbers(picture.shades[::-1])]
    assert (server.pixels(layer="echoes", depth_mm=100) == expected).all()
    settings = RadarSettings(polarization=1, permittivity=6.0, along=Axis(along))
    picture = source.section(TARGETED, settings)
    place = {"x_mm": 150, "y_mm": 90, "along": along, "polarization": 1}
    found = server.pixels("section", **place)
    assert (found == colours[shade_numbers(picture.shades)]).all()


def test_the_coverage_has_the_signs_of_the_window(server):
    server.run(stored=4)
    found = server.pixels(layer="coverage", theme=Theme.NIGHT.value)
    states = server.page._live.shown.map.stop_states
    assert (found == pattern_colours(Theme.NIGHT)[pattern(states, PATTERN_PX)]).all()


def test_no_choice_of_a_browser_changes_what_others_see(server):
    server.run(stored=4)
    before = server.ask()
    pictures = server.pixels(layer="echoes"), server.pixels("section")
    choice = {"x_mm": 100, "y_mm": 50, "depth_mm": 20, "polarization": 1, "along": "y"}
    ground = server.ask(**choice, layer="echoes")["ground"]
    # A place is said in words.
    assert ground["lines"][0] == "X 100, Y 50, depth 20 mm"
    assert ground["counts"][0] == ["Done", 2]
    far = server.ask(x_mm=200, y_mm=110, layer="echoes")["ground"]
    assert far["lines"][1:] == ["Missing", "No trace to show"]
    assert server.ask() == before
    assert (server.pixels(layer="echoes") == pictures[0]).all()
    assert (server.pixels("section") == pictures[1]).all()


def test_a_past_survey_is_never_shown_as_the_running_one(server):
    grid = server.run(stored=4)
    live = server.ask()
    server.open_past(stored=12)
    past = server.ask(survey=FOLDER)
    assert past["title"].startswith("PAST SURVEY: 2026-11-21 ")
    assert past["past"]
    assert past["age_s"] is None
    assert past["carriage"] is None
    assert not live["past"]
    assert live["title"] == "The survey that runs"
    assert server.ask()["ground"]["counts"] == live["ground"]["counts"]
    assert past["ground"]["counts"] != live["ground"]["counts"]
    assert server.page.live(str)["ground"]["survey"] == SURVEY
    shown = server.page._past[FOLDER].traces
    server.page.on_event(trace_at(grid, 4))
    server.tick()
    assert (shown.shown.radar.count, radar_of(server).count) == (12, 5)


def test_while_nobody_watches_no_traces_are_read(server):
    server.page.on_event(SurveyDescribed(description()))
    server.page.on_event(CoverageRuns(SURVEY, 40, (0, 4), (1, 0)))
    for _second in range(5):
        server.now_s += PERIOD_S
        server.page.show_state(server.snapshot)
    assert not server.node.asked
    server.tick()
    server.tick()
    assert server.node.of("traces") == [(SURVEY, (0, 1, 2, 3))]


def test_a_survey_that_is_not_here_is_loading_and_then_says_why(server):
    server.run()
    assert server.ask(survey=FOLDER)["title"] == "Loading…"
    assert server.node.of("read")[-1] == (FOLDER,)
    server.ask(survey=FOLDER)
    assert server.node.of("read").count((FOLDER,)) == 1
    server.node.ticket("read").fail(verbatim("the disk is gone"))
    assert server.ask(survey=FOLDER)["title"] == "the disk is gone"
    server.tick(RETRY_S - 0.5)
    assert server.node.of("read").count((FOLDER,)) == 1
    server.tick()
    assert server.node.of("read").count((FOLDER,)) == 2
    assert server.problems == []


def test_pictures_are_made_once_for_all_browsers_and_only_after_a_change(server, monkeypatch):
    grid = server.run(stored=20)
    made = []
    model = server.page._live.model
    pictures = model.pictures
    monkeypatch.setattr(model, "pictures", lambda: made.append(1) or pictures())
    for browser in range(5):
        server.page.on_event(trace_at(grid, 20, s21=depth_echo(0.1 + browser / 1000)))
        server.tick(0.0)
        server.ask(layer="echoes")
        server.pixels(layer="echoes")
        server.pixels("section", layer="echoes")
    assert len(made) == 1
    server.tick(PERIOD_S)
    revision = server.ask(layer="echoes")["revision"]
    assert len(made) == 2
    assert "ground" not in server.ask(layer="echoes", known=revision)
    server.node.ticket("read").done(marked(MARKER))
    assert "ground" in server.ask(layer="echoes", known=revision)


def test_few_past_surveys_are_kept_and_they_are_forgotten(server):
    folders = [f"20261121T05100{number}_7c9e6679" for number in range(MOST_PAST + 1)]
    for folder in folders[:-1]:
        server.ask(survey=folder)
        server.tick(1.0)
    with pytest.raises(BusyError):
        server.ask(survey=folders[-1])
    server.tick(ROOM_S)
    server.ask(survey=folders[-1])
    assert set(server.page._past) == set(folders[1:])
    server.tick(FORGOTTEN_S + 1.0)
    assert not server.page._past


def test_the_answer_of_the_survey_is_asked_for_and_shown_with_its_candidates(server):
    server.run(stored=8, permittivity=4.0)
    assert server.look() == []  # too few for an image
    server.run(permittivity=4.0)
    for _ in range(3):
        assert server.look() == [(SURVEY,)]
    server.node.ticket("focus").done(focused())
    ground = server.ask(layer="focused")["ground"]
    marks = [one for one in ground["marks"] if one["candidate"]]
    assert {one["number"] for one in marks} == {"1", "2"}
    assert marks[-1]["lines"][:2] == ["Candidate 1", "X 125, Y 90, depth 85 mm"]
    assert "2 places to check" in server.ask()["ground"]["lines"]
    assert server.pixels(layer="focused").shape[:2] == (2, 3)
    # Another screen has entered what the ground is.
    revision = server.ask()["revision"]
    for soil in (4.0, 9.0):
        server.tick(AGAIN_S)
        log = [noted("decision", soil_values(soil, TIME_US))]
        server.node.ticket("read").done(stored(log=log))
        assert ("ground" in server.ask(known=revision)) == (soil == 9.0)
        assert len(server.look()) == 1 + (soil == 9.0)
    assert server.ask(layer="focused")["ground"]["marks"] == []
    image = focused()
    image = replace(image, found=replace(image.found, permittivity=9.0))
    server.node.ticket("focus").done(image)
    assert len(server.ask()["ground"]["marks"]) == 2
    assert {len(one) for one in server.node.of("focus")} == {1}, "with what is stored"


def test_the_picture_of_survey_is_what_is_measured_until_all_is_and_its_traces_are_here(server):
    whole = {"state": state_of(SurveyState.FINISHED, survey_id=SURVEY)}
    whole["progress"] = Progress(SURVEY, 100.0, 40, 40, 0.0)
    server.run(stored=4)
    assert server.page.live(str)["ground"]["layer"] == "coverage"
    server.tick(**whole)
    assert server.page.live(str)["ground"]["layer"] == "echoes"
    assert server.pixels(layer="echoes").size
    server.page = type(server)().page
    server.tick(**whole)
    assert server.page.live(str)["ground"]["layer"] == "coverage"


def test_the_result_is_for_every_page_when_the_survey_has_ended(server):
    server.run()
    server.tick()
    assert server.node.of("focus") == []  # nobody looks at the ground while it is measured
    server.tick(code=SurveyState.FINISHED)
    server.node.ticket("focus").fail(verbatim("the analysis is not installed"))
    notices = server.ask(layer="focused")["ground"]["notice"]
    assert notices[0] == "The analysis is not installed"
    assert server.page.live(str)["result"] is None
    server.tick()
    server.tick(AGAIN_S)
    server.node.ticket("focus").done(focused())
    server.node.ticket("list").done(SurveysListed((past_survey(survey_id=SURVEY),), False))
    assert server.page.live(str)["result"] == {"folder": FOLDER, "text": "2 places to check"}
    server.tick(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY))
    assert server.page.live(str)["result"] is None


def test_without_a_survey_nothing_is_shown(server):
    server.tick()
    answer = server.ask()
    assert (answer["title"], answer["ground"]["area"]) == ("No survey yet.", None)
    assert answer["ground"]["section"] is None
    for kind, layer in (("map", "coverage"), ("map", "echoes"), ("section", "echoes")):
        with pytest.raises(NotFoundError):
            server.pixels(kind, layer=layer)


@each_case(
    "name, value",
    [
        *(("depth_mm", one) for one in (float("nan"), -1, 1e9, "x", True)),
        *(("survey", one) for one in ("../etc", "20261121T051000_7c9e6679/..", "a" * 999)),
        *(("x_mm", 1e300), ("layer", "hiding"), ("along", "z"), ("polarization", 65), ("no", 1)),
    ],
)
def test_what_no_page_sends_is_refused(name, value):
    server = Server()
    server.run()
    with pytest.raises(Gpr20Error):
        server.ask(**{name: value})


def test_the_folder_of_the_running_survey_is_found_and_not_asked_for_all_the_time(server):
    for _second in range(30):
        server.tick()
    assert server.node.asked == []
    server.run(stored=4)
    for _second in range(30):
        server.tick()
    assert len(server.node.of("list")) == 1
    assert server.ask()["folder"] == ""
    server.node.ticket("list").done(SurveysListed((past_survey(survey_id=SURVEY),), False))
    assert server.ask()["folder"] == FOLDER
    server.tick(code=SurveyState.FINISHED)
    assert server.ask()["title"].startswith("Last survey: 2026-11-21 ")
