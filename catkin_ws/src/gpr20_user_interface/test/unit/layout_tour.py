"""What the window shows in turn, so that each of its pages and sheets is seen with all it has."""

import itertools

import numpy as np
from layout_kit import LARGEST, LONG, busiest
from map_kit import FINER, MARKER
from result_kit import BLUE, LOCKED, RED, plug_in, search
from test_surveys_page import many
from view_kit import (
    PAST,
    RESTING,
    SURVEY,
    depth_echo,
    description,
    make_grid,
    moving,
    past_survey,
    snapshot,
    state_of,
    trace_at,
)
from window_helpers import click, hold, show

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.additions import AdditionsRead, RelatedSurvey
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.past_surveys import Listed
from gpr20_operator.ground.trace_events import SurveyDescribed, SurveysListed
from gpr20_operator.plan.fields import VALUE_TILES, default_parameters
from gpr20_operator.robot.notices import Refused, analyzer_notice, refusal_notice
from gpr20_operator.robot.remote_control import WebStatusReported
from gpr20_operator.robot.robots import RobotReported, RobotsFound
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.window.rail import TabName

WITH_DETAILS = Message("{reason}", reason=verbatim(LONG), details=LONG)
IDENTITY = "Rohde&Schwarz,ZNB20-4Port,1311601062100123,3.40.0.1 with options K2, K4 and B16"
NAME = "Ana María Rodríguez Vargas de la Cruz y Peña"
SITE = "Vereda El Salado, franja 12, junto al camino viejo"
PEOPLE = Annotation(NAME, SITE, "W " * 2000, Wgs84Position(-89.123456, -179.123456))
OWNER = "/a_program_with_a_long_name_1795493315529903"
CONDITIONS = (
    {"master_alive": False},
    {"control_alive": False, "control_silent_s": None},
    {"control_alive": False, "control_silent_s": 86399.0},
    {"interrupted": True},
    {"service": verbatim("moving the X axis")},
    {"still_s": 86399.0},
    {"ignored_sender": OWNER},
)
DIGEST = " ".join(f"{number:02X}" * 2 for number in range(16))
WEB = WebStatusReported("gpr20-pc.campo.local", 8443, DIGEST, 20, NAME)
ROBOTS = [f"/{'w' * 20}{number}" for number in range(20)]
ENDED = snapshot(SurveyState.FINISHED, state=state_of(SurveyState.FINISHED, survey_id=SURVEY))


def plan(window):
    window.show_tab(TabName.SURVEY)
    window.survey.preview = LARGEST
    show(window, busiest(SurveyState.IDLE))


def after_plan(act):
    def stop(window):
        plan(window)
        act(window)

    return stop


def running(code):
    def stop(window):
        window.show_tab(TabName.SURVEY)
        show(window, busiest(code))

    return stop


def band(**changes):
    def stop(window):
        # What is shown for the first time has its size with the next refresh.
        for _ in range(2):
            show(window, busiest(**changes))

    return stop


def stop_that_nobody_confirms(window):
    show(window, busiest(axes=()))
    click(window.top_bar.stop)


def details(window):
    window.notice.show_notice(refusal_notice(Refused.START, WITH_DETAILS))
    window.notice.details_button.click()


def result(window):
    window.show_tab(TabName.SURVEY)
    show(window, busiest(SurveyState.SURVEYING))
    show(window, ENDED)
    search(window.result.result, window.node)
    show(window, ENDED)


def past_result(window):
    show(window, busiest(state=state_of(SurveyState.FINISHED, LONG, PAST)))
    window.past.result_requested.emit(SURVEY)
    search(window.result.result, window.node)
    show(window, busiest(state=state_of(SurveyState.FINISHED, LONG, PAST)))


def stick(window):
    result(window)
    window.result.stick.click()
    plug_in(window.node, BLUE, RED, LOCKED)
    show(window, ENDED)


def ground(window):
    grid = make_grid(x_stop_mm=583.33, x_start_mm=416.67, y_start_mm=683.33, y_stop_mm=783.33)
    window.show_tab(TabName.GROUND)
    show(window, busiest(state=state_of(SurveyState.FINISHED, LONG, SURVEY)))
    window.on_event(SurveyDescribed(description()))
    live = window.traces.live
    live.begin(grid)
    failures = {10: verbatim("the VNA did not answer within 90 s; check cable and address")}
    verdict = verbatim("INCOMPLETE: 11 of 40 planned traces are stored, 1 failed, 28 missing")
    runs = CoverageRuns(SURVEY, 40, (0, 10, 11, 12), (1, 3, 1, 0), failures, verdict)
    live.map.set_coverage(runs)
    draw = np.random.default_rng(1)
    for index in range(10):
        noise = 1e-4 * (draw.standard_normal(501) + 1j * draw.standard_normal(501))
        live.take_traces([trace_at(grid, index, depth_echo(0.1, level=0.05) + noise)])
    related = RelatedSurvey(FINER, "20261121T061000_7c9e6679", True, Area(120, 150, 60, 80))
    window.on_event(AdditionsRead(SURVEY, (MARKER,), (related,)))
    window.draw()


def on_ground(name):
    def stop(window):
        ground(window)
        getattr(window.ground.view, name).click()
        window.draw()

    return stop


def surveys(window):
    window.show_tab(TabName.SURVEYS)
    whole = past_survey(stored_traces=25000, planned_traces=25000, name="Field 7, north")
    window.on_event(SurveysListed("", (whole, *many(60)), False))
    window.past.choose(whole)
    show(window, busiest(SurveyState.IDLE))


def no_survey_found(window):
    surveys(window)
    window.past.search_for("no such survey, wherever it may be")


def no_survey_stored(window):
    window.past.search_for("")
    window.past.show_listed(Listed.ALL)
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (), False))


def list_fails(window):
    no_survey_stored(window)
    window.traces.past.set_problem(verbatim("the storage does not answer; check the server"))
    show(window, snapshot())


def search_keys(window):
    surveys(window)
    window.past.search.click()


def robots(window):
    window.on_event(RobotsFound(frozenset({*ROBOTS, "/"})))
    now = busiest(SurveyState.IDLE)
    for name in ROBOTS:
        window.on_event(RobotReported(name, now.state))
    window.settings.open()
    show(window, now)


def other_robot(window):
    robots(window)
    window.settings.robot_button.click()
    show(window, busiest(SurveyState.IDLE))


def remote(window):
    window.on_event(WEB)
    show(window, busiest(SurveyState.PAUSED))
    window.settings.remote_button.click()


def armed(window):
    remote(window)
    hold(window.remote.hold)
    show(window, busiest(SurveyState.PAUSED))


def not_armed(window):
    window.remote.end()
    window.settings.remote_button.click()
    show(window, busiest(service=verbatim("moving the X axis by 100 mm")))


def service(window):
    window.on_event(RobotsFound(frozenset()))
    window.show_tab(TabName.ROBOT)
    show(window, busiest(SurveyState.FINISHED))
    window.robot.overview.entered.emit()
    show(window, busiest(SurveyState.FINISHED))


def instruments(window):
    service(window)
    window.robot.service.switch_button.click()
    show(window, busiest(SurveyState.FINISHED))


def locked(window):
    plan(window)
    window.touch_binding.set_locked(True)


def unlocked(window):
    window.touch_binding.set_locked(False)
    plan(window)


STOPS = {
    "plan": plan,
    **{
        f"tile {tile.name.lower()}": after_plan(
            lambda window, tile=tile: window.values.show_tile(tile)
        )
        for tile in VALUE_TILES
    },
    "check plan": after_plan(lambda window: window.control.check_plan.click()),
    "profiles": after_plan(lambda window: window.profiles.show_profiles(default_parameters())),
    "notes": after_plan(lambda window: window.annotation.show_annotation("", PEOPLE)),
    "start": after_plan(
        lambda window: window.start_sheet.ask_start(default_parameters(), 4.0, PEOPLE)
    ),
    "resume": after_plan(lambda window: window.start_sheet.ask_resume_past("20261121T051000_7c9")),
    "other analyzer": after_plan(lambda window: window.start_sheet.ask_resume_with(IDENTITY)),
    **{code.name.lower(): running(code) for code in SurveyState},
    **{
        f"band {number}": band(axes=axes, **changes)
        for number, (changes, axes) in enumerate(
            itertools.product(CONDITIONS, (RESTING, moving(*AxisId, owner=OWNER)))
        )
    },
    **{
        f"refused {refused.name}": lambda window, refused=refused: window.notice.show_notice(
            refusal_notice(refused, WITH_DETAILS)
        )
        for refused in Refused
    },
    "details": details,
    "question": lambda window: window.question.ask(analyzer_notice(WITH_DETAILS, IDENTITY), list),
    "stop": stop_that_nobody_confirms,
    "result": result,
    "past result": past_result,
    "stick": stick,
    "ground": ground,
    "layers": on_ground("layers"),
    "finer": on_ground("finer"),
    "marker": on_ground("set_marker"),
    "surveys": surveys,
    "no survey found": no_survey_found,
    "no survey stored": no_survey_stored,
    "the list fails": list_fails,
    "search": search_keys,
    "settings": robots,
    "robots": other_robot,
    "remote": remote,
    "armed": armed,
    "not armed": not_armed,
    "service": service,
    "instruments": instruments,
    "locked": locked,
    "unlocked": unlocked,
}
