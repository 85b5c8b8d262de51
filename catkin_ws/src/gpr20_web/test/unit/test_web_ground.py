"""GROUND for browsers: the pictures are those of the window, and none shows a wrong one."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
import view_kit
from case_kit import each_case
from map_kit import focused
from PIL import Image
from result_kit import TIME_US, Requests, noted, stored
from view_kit import FOLDER, PAST, SURVEY, depth_echo, description, past_survey, snapshot, trace_at
from web_kit import route_of

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import Place, grid_from_description
from gpr20_operator.ground.sources import Axis, EchoSource, RadarSettings
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.jobs.pictures import StoredSurvey, SurveysListed, TracesRead
from gpr20_operator.palette import Theme, pattern, pattern_colours, shade_colours, shade_numbers
from gpr20_survey.folder.log_record import soil_values
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import TraceBlock
from gpr20_web.calls import Body, Call, Person, Role
from gpr20_web.faults import BusyError
from gpr20_web.low.event_streams import json_text
from gpr20_web.mid.ground_page import FORGOTTEN_S, MOST_PAST, PERIOD_S, ROOM_S, GroundPage
from gpr20_web.mid.shown_ground import AGAIN_S, PATTERN_PX

PLANNED = 40
ANA = Person("Ana", Role.WATCH, "secret", "10.0.0.7")


class Server:
    """A page with what its node does for it."""

    def __init__(self):
        self.now_s = 1000.0
        self.node = Requests()
        self.page = GroundPage(self.node, lambda: self.now_s, lambda _problem: None)
        self.snapshot = snapshot()

    def tick(self, seconds=PERIOD_S, **state):
        """Let time pass while somebody watches; say what the robot does."""
        self.page.live(str)
        if state:
            self.snapshot = snapshot(**state)
        self.now_s += seconds
        self.page.show_state(self.snapshot)

    def ask(self, path="/api/ground", **values):
        route, parts = route_of(self.page.routes, "GET", path)
        asked = {one: values.pop(one) for one in ("survey", "known") if one in values}
        asked["choice"] = json.dumps(values)
        answer = route.answer(Call(ANA, ANA.address, asked, parts))
        if not isinstance(answer, Body):
            # As it is sent: nothing in it is infinite or unknown to JSON.
            assert json.loads(json_text(answer)) == answer
        return answer

    def pixels(self, kind="map", **values):
        """Return red, green, blue and alpha of a picture."""
        body = self.ask(f"/api/ground/{kind}.png", **values)
        assert body.kind == "image/png"
        return np.array(Image.open(io.BytesIO(body.content)).convert("RGBA"))

    def look(self):
        """Look at the map until an image is asked for."""
        self.ask()
        self.tick()
        return self.node.of("focus")

    def run(self, stored=PLANNED, survey=SURVEY, depth_m=0.1, **described):
        """Let a survey run of which the first traces are stored and here."""
        text = description(survey_id=survey, **described)
        grid = grid_from_description(text)
        self.page.on_event(SurveyDescribed(text))
        runs = ((0, stored), (1, 0)) if stored < PLANNED else ((0,), (1,))
        self.page.on_event(CoverageRuns(survey, PLANNED, *runs))
        for index in range(stored):
            # No row is like another one: nothing may be upside down.
            s21 = depth_echo(depth_m, level=10.0 ** (-index / 40.0))
            self.page.on_event(trace_at(grid, index, s21=s21))
        self.tick(state=view_kit.state_of(SurveyState.SURVEYING, survey_id=survey))
        return grid

    def open_past(self, stored):
        """Ask for a past survey, and let the storage answer."""
        self.ask(survey=FOLDER)
        self.node.ticket("list").done(SurveysListed((past_survey(),), False))
        text = description(survey_id=PAST)
        self.node.ticket("read").done(StoredSurvey(text, tuple(range(stored))))
        # The first time they may still be on their way.
        self.tick()
        self.tick()
        grid = grid_from_description(text)
        traces = [trace_at(grid, index, s21=depth_echo(0.2)) for index in range(stored)]
        self.node.ticket("traces").done(TracesRead(TraceBlock.of(PAST, traces), {}))
        self.tick()


@pytest.fixture
def server():
    return Server()


def test_the_pictures_are_those_of_the_window(server):
    server.run(permittivity=6.0)
    source, colours = EchoSource(server.page._live.traces.live.radar), shade_colours()
    shades = source.slice(RadarSettings(depth_m=0.1, permittivity=6.0)).shades[::-1]
    found = server.pixels(layer="echoes", depth_mm=100)
    assert (found == colours[shade_numbers(shades)]).all()
    for along in ("x", "y"):
        settings = RadarSettings(polarization=1, permittivity=6.0, along=Axis(along))
        shades = source.section(Place(150.0, 90.0), settings).shades
        found = server.pixels("section", x_mm=150, y_mm=90, along=along, polarization=1)
        assert (found == colours[shade_numbers(shades)]).all()
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
    echoes = server.pixels(layer="echoes")
    server.open_past(stored=12)
    past = server.ask(survey=FOLDER)
    assert past["title"].startswith("PAST SURVEY: 2026-11-21 ")
    assert (past["past"], past["age_s"], past["carriage"]) == (True, None, None)
    assert (live["past"], live["title"]) == (False, "The survey that runs")
    assert server.ask()["ground"]["counts"] == live["ground"]["counts"]
    assert past["ground"]["counts"] != live["ground"]["counts"]
    assert (server.pixels(layer="echoes", survey=FOLDER) != echoes).any()
    assert server.page.live(str)["ground"]["survey"] == SURVEY
    server.page.on_event(trace_at(grid, 4))
    server.tick()
    grounds = (server.page._past[FOLDER], server.page._live)
    assert [one.shown.radar.count for one in grounds] == [12, 5]


def test_no_picture_is_that_of_another_choice_or_of_the_survey_before(server):
    pictures = []
    for survey, depth_m in ((SURVEY, 0.1), (PAST, 0.2)):
        server.run(survey=survey, depth_m=depth_m)
        pictures += [server.pixels(layer="echoes", depth_mm=one).tobytes() for one in (100, 150)]
    assert len(set(pictures)) == 4


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
    assert marks[-1]["place"] == pytest.approx([125.0, 90.0, 85.0])
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
    server.tick(state=view_kit.state_of(SurveyState.SURVEYING, survey_id=SURVEY))
    assert server.page.live(str)["result"] is None


REFUSED = (
    *(("depth_mm", one) for one in (float("nan"), -1, 1e9, "x", True)),
    *(("survey", one) for one in ("../etc", "20261121T051000_7c9e6679/..", "a" * 999)),
    *(("x_mm", 1e300), ("layer", "hiding"), ("along", "z"), ("polarization", 65), ("no", 1)),
)


@each_case("name, value", REFUSED)
def test_what_no_page_sends_is_refused(name, value):
    server = Server()
    server.run()
    with pytest.raises(Gpr20Error):
        server.ask(**{name: value})
