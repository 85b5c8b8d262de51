"""MAP and RADAR for browsers: the pictures are those of the window, and none shows a wrong one."""

from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from hiding_kit import a_map
from map_kit import MARKER, focused
from view_kit import depth_echo, description, past_survey, state_of, trace_at
from web_ground_kit import BEN, FOLDER, PAST, PERIOD_S, SURVEY, Server

from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import AdditionsRead
from gpr20_operator.ground.cells import MARKS, TILES, Cell
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.records import Axis, Colours, Place, RadarSettings
from gpr20_operator.ground.shade_colours import colour_table, shade_numbers
from gpr20_operator.ground.sources import EchoSource
from gpr20_operator.ground.trace_events import ReadingFailed, SurveyDescribed, SurveysListed
from gpr20_operator.palette import Theme
from gpr20_operator.robot.events import Replay
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.errors import BadRequestError, BusyError, NotFoundError, NotNowError
from gpr20_web.mid.ground_page import AGAIN_S, FORGOTTEN_S, MOST_PAST, ROOM_S
from gpr20_web.mid.shown_ground import AGAIN_REFRESHES

TARGETED = Place(150.0, 90.0)


@pytest.fixture
def server():
    return Server()


def radar_of(server):
    return server.page._live.traces.live.radar


@pytest.mark.parametrize("along", ["x", "y"])
def test_map_and_section_have_the_colours_of_the_window(server, along):
    server.run(permittivity=6.0)
    source = EchoSource(radar_of(server))
    picture = source.slice(RadarSettings(depth_m=0.1, permittivity=6.0))
    colours = colour_table(Colours.ENVELOPE)
    expected = colours[shade_numbers(picture.shades[::-1], picture.signed)]
    assert (server.pixels(layer="echoes", depth="100") == expected).all()
    settings = RadarSettings(
        polarization=1, permittivity=6.0, gain_db_per_ns=2.0, remove_background=False,
        along=Axis(along), colours=Colours.GREY,
    )  # fmt: skip
    picture = source.line(TARGETED, settings)
    found = server.pixels(
        *("section",), section="1", x="150", y="90", along=along, polarization="1",
        gain="2", background="0", colours=Colours.GREY.value,
    )  # fmt: skip
    expected = colour_table(Colours.GREY)[shade_numbers(picture.shades, picture.signed)]
    assert (found == expected).all()


def test_the_coverage_has_the_signs_of_the_window(server):
    server.run(stored=4)
    found = server.pixels(layer="coverage", theme=Theme.NIGHT.value)
    assert found.shape[:2] == (4 * 8, 5 * 8)
    colours = [(0, 0, 0, 0), *((*bytes.fromhex(one.of(Theme.NIGHT)[1:]), 255) for one in MARKS)]
    # The first row of the plan is the lowest one of the picture.
    done, missing = found[-8:, :8], found[:8, :8]
    for cells, cell in ((done, Cell.DONE), (missing, Cell.MISSING)):
        tile = TILES[cell][: 8 if cell is Cell.MISSING else None, :8][-8:]
        assert (cells == np.array(colours)[tile]).all()
    assert server.page.picture() == server.ask("/api/ground/map.png", layer="coverage").content


def test_what_loads_is_not_shown_as_missing(server):
    server.open_past(stored=12)
    server.page._past[FOLDER].traces.shown.radar.begin(
        server.page._past[FOLDER].traces.shown.map.grid
    )
    server.tick()
    answer = server.ask(survey=FOLDER)
    assert "loading" in answer["ground"]["layers"]
    assert any("loading 0/12" in one for one in answer["ground"]["notes"])
    loading = server.pixels(survey=FOLDER, layer="loading")
    assert loading[:, :, 3].any()
    assert not loading[:8, :8, 3].any()


def test_no_choice_of_a_browser_changes_what_others_see(server):
    server.run(stored=4)
    before = server.ask(section="1")
    pictures = server.pixels(layer="echoes"), server.pixels("section", section="1")
    ground = server.ask(
        *("/api/ground",), x="100", y="50", depth="20", polarization="1",
        layer="echoes", gain="5", background="0", along="y",
    )["ground"]  # fmt: skip
    # A place is said in words.
    assert ground["lines"][0] == "X 100, Y 50, depth 20 mm"
    assert ground["counts"][0] == ["done", "Done", 2]
    far = server.ask(x="200", y="110", layer="echoes")["ground"]
    assert far["lines"][1:] == ["Missing", "No trace to show"]
    assert server.ask(section="1") == before
    assert (server.pixels(layer="echoes") == pictures[0]).all()
    assert (server.pixels("section", section="1") == pictures[1]).all()


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


def test_a_survey_that_begins_is_not_mixed_with_the_last_one(server):
    server.run()
    server.look()
    server.node.ticket("focus").done(focused())
    server.page.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    assert len(server.ask()["ground"]["marks"]) == 3
    server.page.on_event(SurveyDescribed(description(survey_id=PAST)))
    after = server.ask()
    assert after["title"] == "Loading…"
    assert after["ground"]["counts"][0][2] is None
    assert not after["ground"]["marks"]
    assert server.page.live(str)["ground"]["survey"] == ""


def test_while_nobody_watches_no_traces_are_read(server):
    server.page.on_event(SurveyDescribed(description()))
    server.page.on_event(CoverageRuns(SURVEY, 40, (0, 4), (1, 0)))
    for _second in range(5):
        server.now_s += PERIOD_S
        server.page.refresh(server.snapshot)
    assert not server.storage.asked
    server.tick()
    server.tick()
    assert server.storage.of("traces") == [(SURVEY, (0, 1, 2, 3))]


def test_a_survey_that_is_not_here_is_loading_and_then_says_why(server):
    server.run()
    assert server.ask(survey=FOLDER)["title"] == "Loading…"
    assert server.storage.of("survey") == [(FOLDER,)]
    server.ask(survey=FOLDER)
    assert len(server.storage.of("survey")) == 1
    server.page.on_event(ReadingFailed(verbatim("the disk is gone")))
    assert server.ask(survey=FOLDER)["title"] == "the disk is gone"
    for _second in range(AGAIN_REFRESHES + 1):
        server.page.on_event(ReadingFailed(verbatim("the disk is gone")))
        server.tick()
    assert len(server.storage.of("survey")) == 2
    assert server.problems == []


def test_a_replay_is_called_a_replay(server):
    server.run(code=None)
    replay = Replay(SURVEY, "2026-11-21T05:10:00", FOLDER)
    state = state_of(SurveyState.SURVEYING, survey_id=SURVEY)
    server.tick(state=state, replay=replay)
    answer = server.ask()
    assert answer["title"].startswith("REPLAY: ")
    assert answer["past"]
    with pytest.raises(NotNowError):
        server.ask("/api/ground/hide", "POST")
    assert server.look() == []


def test_pictures_are_made_once_for_all_browsers_and_only_after_a_change(server, monkeypatch):
    grid = server.run(stored=20)
    made = []
    model = server.page._live.model
    pictures = model.pictures
    monkeypatch.setattr(model, "pictures", lambda alongs: made.append(1) or pictures(alongs))
    for browser in range(5):
        server.page.on_event(trace_at(grid, 20, s21=depth_echo(0.1 + browser / 1000)))
        server.tick(0.0)
        server.ask(layer="echoes", section="1")
        server.pixels(layer="echoes", section="1")
        server.pixels("section", layer="echoes", section="1")
    assert len(made) == 1
    server.tick(PERIOD_S)
    revision = server.ask(layer="echoes", section="1")["revision"]
    assert len(made) == 2
    assert "ground" not in server.ask(layer="echoes", section="1", known=revision)
    server.page.on_event(AdditionsRead(SURVEY, (), ()))
    assert "ground" in server.ask(layer="echoes", section="1", known=revision)


def test_few_past_surveys_are_kept_and_they_are_forgotten(server):
    folders = [f"20261121T05100{number}_7c9e6679" for number in range(MOST_PAST + 1)]
    for folder in folders[:-1]:
        server.ask(survey=folder)
        server.tick(1.0)
    with pytest.raises(BusyError):
        server.ask(survey=folders[-1], person=BEN)
    server.tick(ROOM_S)
    server.ask(survey=folders[-1], person=BEN)
    assert set(server.page._past) == set(folders[1:])
    server.tick(FORGOTTEN_S + 1.0)
    assert not server.page._past


def test_the_answer_of_the_survey_is_asked_for_and_shown_with_its_candidates(server):
    server.run(stored=8, permittivity=4.0)
    assert server.look() == []  # too few for an image
    server.run(permittivity=4.0)
    for _ in range(3):
        assert server.look() == [(SURVEY, 0.0)]
    server.node.ticket("focus").done(focused())
    ground = server.ask(layer="focused")["ground"]
    assert ground["traces_focused"] == 9
    marks = [one for one in ground["marks"] if one["candidate"]]
    assert {one["number"] for one in marks} == {"1", "2"}
    assert marks[-1]["lines"][:2] == ["Candidate 1", "X 125, Y 90, depth 85 mm"]
    assert "2 places to check, 0 weaker echoes" in server.ask()["ground"]["lines"]
    assert server.pixels(layer="focused").shape[:2] == (2, 3)
    # The same answer is nothing new; another one is, whoever has entered what the ground is.
    revision = server.ask()["revision"]
    for image in (focused(), with_soil(focused(), 9.0)):
        asked = len(server.look())
        server.ask()
        server.tick(AGAIN_S)
        assert len(server.node.of("focus")) == asked + 1
        server.node.ticket("focus").done(image)
        known = server.ask(known=revision)
        assert ("ground" in known) == (image.found.permittivity == 9.0)
    assert len(known["ground"]["marks"]) == 2
    assert {one[1] for one in server.node.of("focus")} == {0.0}


def with_soil(image, permittivity):
    return replace(image, found=replace(image.found, permittivity=permittivity))


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
    server.page.on_event(SurveysListed("", (past_survey(survey_id=SURVEY),), False))
    assert server.page.live(str)["result"] == {"folder": FOLDER, "text": "2 places to check"}
    server.tick(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY))
    assert server.page.live(str)["result"] is None


def test_hiding_places_are_said_for_a_target_and_never_searched_beside_a_survey(server):
    server.run()
    with pytest.raises(NotNowError):
        server.ask("/api/ground/hide", "POST")
    with pytest.raises(NotFoundError):
        server.pixels(layer="hiding")
    server.tick(code=SurveyState.FINISHED)
    server.ask("/api/ground/hide", "POST", target="type-72")
    assert server.node.of("hide") == [(SURVEY, 0.0, "type-72")]
    found = a_map([[[10, 0]], [[10, 0]]], np.full((2, 1, 2), 10), survey_id=SURVEY)
    server.node.ticket("hide").done(found)
    ground = server.ask()["ground"]
    assert ground["layers"]["hiding"] == pytest.approx([-50.0, 150.0, -50.0, 50.0])
    assert ground["hiding"][0].startswith("This map holds for this target only")
    hatched = server.pixels(layer="hiding")[:, :, 3]
    assert not hatched[:, :8].any()
    assert hatched[:, 8:].any()
    server.ask("/api/ground/hide", "POST")
    server.tick(0.0, code=SurveyState.SURVEYING)
    assert server.node.cancelled
    assert not server.ask()["hide"]["running"]
    assert "A survey is running" in server.ask()["hide"]["said"]


def test_without_a_survey_nothing_is_shown(server):
    server.tick()
    answer = server.ask(section="1")
    assert (answer["title"], answer["ground"]["area"]) == ("No survey yet.", None)
    assert answer["ground"]["section"] is server.page.picture() is None
    for kind, layer in (("map", "coverage"), ("map", "echoes"), ("section", "echoes")):
        with pytest.raises(NotFoundError):
            server.pixels(kind, layer=layer, section="1")


@each_case(
    "name, value",
    [
        *(("depth", one) for one in ("nan", "-1", "1e9", "x", "1" * 99)),
        *(("survey", one) for one in ("../etc", "20261121T051000_7c9e6679/..", "a" * 999)),
        *(("x", "1e300"), ("layer", "__class__"), ("along", "z"), ("polarization", "65")),
        *(("gain", one) for one in ("21", True, [1], {})),
    ],
)
def test_what_no_page_sends_is_refused(name, value):
    server = Server()
    server.run()
    with pytest.raises(BadRequestError):
        server.ask(**{name: value})


def test_the_folder_of_the_running_survey_is_found_and_not_asked_for_all_the_time(server):
    for _second in range(30):
        server.page.on_event(ReadingFailed(verbatim("no")))
        server.tick()
    assert len(server.storage.asked) == 0
    server.run(stored=4)
    for _second in range(30):
        server.tick()
    assert len(server.storage.of("list")) == 1
    assert server.ask()["folder"] == ""
    server.page.on_event(SurveysListed("", (past_survey(survey_id=SURVEY),), False))
    assert server.ask()["folder"] == FOLDER
