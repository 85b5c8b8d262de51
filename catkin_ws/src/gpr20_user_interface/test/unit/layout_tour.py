"""What the window shows in turn, so that each of its pages and sheets is seen with all it has.

What the robot says in it is Spanish: in a Spanish window every English word is then one of ours.
"""

import itertools

from candidate_examples import candidate
from map_kit import MARKER, marked
from result_examples import a_map
from result_kit import BLUE, LOCKED, RED, plug_in, search, stored
from view_kit import (
    FOLDER,
    PAST,
    SURVEY,
    description,
    make_grid,
    past_survey,
    snapshot,
    state_of,
    trace_at,
)
from window_helpers import click, hold, open_field, show, take_list

from gpr20_common.message import Fault, Message, verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, HealthReport, NodeHealth
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.jobs.pictures import Exported
from gpr20_operator.plan.fields import SPECS, TILE_FIELDS, default_parameters
from gpr20_operator.plan.form import SurveyPreview
from gpr20_operator.robot.events import ControlState, CurrentPosition, Progress, TargetPosition
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_operator.robot.remote_control import WebStatusReported
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.markers import What
from gpr20_survey.plan.survey_points import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import Flag
from gpr20_user_interface.pages.plan_sheets import VALUE_TILES
from gpr20_user_interface.widgets.bars import TabName

LONG = "el VNA en 192.168.100.100 no contesta; revise el cable y la dirección. " * 9
LARGEST = SurveyPreview(
    stops=500000,
    traces=1000000,
    x_spacing_mm=12.34,
    y_spacing_mm=23.45,
    quarter_wavelength_mm=1.234,
    cost=SurveyCost(99 * 86400.0 + 86399.0, 123456 * 10**6),
)
WITH_DETAILS = Message("{reason}", reason=verbatim(LONG), details=LONG)
IDENTITY = "Rohde&Schwarz,ZNB20-4Port,1311601062100123,3.40.0.1 con opciones K2, K4 y B16"
OTHER_VNA = verbatim(
    f"el VNA es {IDENTITY}, pero la campaña se midió con {IDENTITY}; conecte ese VNA de nuevo, o "
    "acepte el otro cuando reanude la campaña"
)
NAME = "Ana María Rodríguez Vargas de la Cruz y Peña"
SITE = "Vereda El Salado, franja 12, junto al camino viejo"
LONGEST = {
    "vna_address": "192.168.100.100",
    **{"start_frequency_hz": "999.999", "stop_frequency_hz": "6000", "frequency_points": "4000"},
    **{"x_start_mm": "123.45", "x_stop_mm": "649.99", "x_spacing_mm": "12.34"},
    **{"y_start_mm": "123.45", "y_stop_mm": "799.99", "y_spacing_mm": "23.45"},
    **{"polarizations_deg": "-90, -45, 0, 45", "permittivity": "12.345"},
    **{"if_bandwidth_hz": "100000", "averages": "1000", "output_power": "HIGH"},
}
PEOPLE = Annotation(NAME, SITE, "W " * 2000, Wgs84Position(-89.123456, -179.123456))
FIRST_FIELDS = [SPECS[TILE_FIELDS[tile][0]] for tile in VALUE_TILES]
WEB = WebStatusReported("gpr20-pc.campo.local", 8443, " ".join(["4F4F"] * 16), 20, NAME)


MANY = [
    candidate(number, 1234.0, 1234.0, 1234.0, 31.0, list(Flag)[: (number - 1) // 8])
    for number in range(1, 51)
]
REFUSED = verbatim("los ecos concuerdan con toda permitividad").with_fault(
    Fault("a.b", verbatim("Escriba la permitividad del suelo y pruebe de nuevo. O use otra."))
)
ENDED = snapshot(SurveyState.FINISHED, state=state_of(SurveyState.FINISHED, LONG, SURVEY))


def is_cut(label):
    """Return whether some of the text of a LinesLabel has no room."""
    return "".join("".join(label.shown_lines()).split()) != "".join(label.text().split())


def busiest(code=SurveyState.SURVEYING, **other):
    values = {"calibration": "MODERATE_POWER"}
    levels = itertools.cycle([HealthLevel.STALE, *HealthLevel])
    nodes = tuple(
        NodeHealth(name, level, verbatim(LONG), values)
        for name, level in zip((*EXPECTED_NODES, "simulator"), levels)
    )
    values = {
        "state": ControlState(code, verbatim(LONG), "id", True),
        "progress": Progress("id", 99.99, 1000000, 999999, 10**7),
        "current": CurrentPosition(650.0, 800.0, -90.0),
        "target": TargetPosition(650.0, 800.0, -90.0),
        "health": HealthReport(nodes),
        **other,
    }
    return snapshot(code, **values)


def plan(*acts):
    """Show CONTROL with the longest values, and then what some acts open."""

    def stop(window):
        window.touch_binding.set_locked(False)
        window.show_tab(TabName.SURVEY)
        window.survey.preview = LARGEST
        take_list(window, ())
        window.control.form.set_texts(LONGEST)
        window.control.show_plan()
        show(window, busiest(SurveyState.IDLE))
        for act in acts:
            act(window)

    return stop


def running(code=SurveyState.SURVEYING, **changes):
    def stop(window):
        window.show_tab(TabName.SURVEY)
        # What is shown for the first time has its size with the next refresh.
        for _ in range(2):
            show(window, busiest(code, **changes))

    return stop


def to_resume(window):
    survey = past_survey(name="W" * 60, stored_traces=999999, planned_traces=1000000)
    take_list(window, (survey,))
    show(window, busiest(SurveyState.IDLE))
    assert window.control.resume.isVisible()


def wrong(spec):
    def act(window):
        window.control.form.set_text(spec.name, "-7 x5")
        window.control.show_plan()
        for tile in (window.control.tiles[spec.tile], window.control.start):
            assert tile.sentence.isVisible() and not is_cut(tile.sentence), tile.sentence.text()

    return plan(act)


def keys(name, text=None):
    """The pad of a field of the records."""

    def act(window):
        window.annotation.show_annotation(FOLDER, PEOPLE)
        window.annotation.tiles[name].click()
        if text:
            window.annotation.pad.edit.setPlainText(text)
        else:
            window.annotation.pad.letters.shift.click()

    return plan(act)


def stop_that_nobody_confirms(window):
    show(window, busiest(axes=()))
    click(window.top_bar.stop)


def past_result(window):
    other = busiest(state=state_of(SurveyState.FINISHED, LONG, PAST))
    show(window, other)
    window.past.result_requested.emit(SURVEY)
    search(window.result.result, window.node)
    show(window, other)


def ground(window):
    grid = make_grid(x_stop_mm=583.33, x_start_mm=416.67, y_start_mm=683.33, y_stop_mm=783.33)
    window.show_tab(TabName.GROUND)
    show(window, busiest(state=state_of(SurveyState.FINISHED, LONG, SURVEY)))
    window.on_event(SurveyDescribed(description()))
    live = window.traces.live
    live.begin(grid)
    failures = {10: verbatim("el VNA no contestó en 90 s; revise el cable y la dirección")}
    runs = CoverageRuns(SURVEY, 40, (0, 10, 11, 12), (1, 3, 1, 0), failures)
    live.map.set_coverage(runs)
    live.take_traces([trace_at(grid, index) for index in range(10)])
    window.refresh()
    window.node.ticket("read").done(marked(MARKER))
    window.refresh()


def on_ground(name):
    def stop(window):
        ground(window)
        getattr(window.ground.view, name).click()
        window.refresh()

    return stop


def surveys(window):
    window.show_tab(TabName.SURVEYS)
    whole = past_survey(stored_traces=25000, planned_traces=25000, name="Campo 7, norte")
    many = [past_survey(folder=f"{FOLDER[:-2]}{one}", name=f"Lane {one}") for one in range(60)]
    take_list(window, (whole, *many))
    window.past.choose(whole)
    show(window, busiest(SurveyState.IDLE))


def list_fails(window):
    window.show_tab(TabName.SURVEYS)
    take_list(window, ())
    window.traces.past.set_problem(verbatim("el servidor no contesta"))
    show(window, snapshot())


def armed(window):
    window.on_event(WEB)
    show(window, busiest(SurveyState.PAUSED))
    window.settings.remote_button.click()
    hold(window.remote.hold)
    show(window, busiest(SurveyState.PAUSED))


def service(window):
    window.show_tab(TabName.ROBOT)
    show(window, busiest(SurveyState.FINISHED))
    window.robot.overview.entered.emit()
    show(window, busiest(SurveyState.FINISHED))


def instruments(window):
    service(window)
    window.robot.service.switch_button.click()
    show(window, busiest(SurveyState.FINISHED))


def start_sheet(name, *arguments):
    return plan(lambda window: getattr(window.start_sheet, name)(*arguments))


def refused(one):
    return lambda window: window.notice.show_notice(refusal_notice(one, WITH_DETAILS))


STOPS = {
    "locked": plan(lambda window: window.touch_binding.set_locked(True)),
    "plan": plan(),
    "to resume": plan(to_resume),
    "field": plan(lambda window: open_field(window, "x_start_mm")),
    **{f"wrong {spec.name}": wrong(spec) for spec in FIRST_FIELDS},
    "notes": plan(lambda window: window.annotation.show_annotation("", PEOPLE)),
    **{f"keys {name}": keys(name) for name in ("name", "operator", "site", "notes")},
    "position": keys("position", "91,0"),
    "start": start_sheet("ask_start", default_parameters(), 4.0, PEOPLE),
    "resume": start_sheet("ask_resume_past", FOLDER),
    "other analyzer": start_sheet("ask_resume_with", IDENTITY, OTHER_VNA),
    **{code.name.lower(): running(code) for code in SurveyState},
    **{f"refused {one.name}": refused(one) for one in Refused},
    "stop": stop_that_nobody_confirms,
    "past result": past_result,
    "ground": ground,
    **{name: on_ground(name) for name in ("layers", "set_marker")},
    "surveys": surveys,
    "the list fails": list_fails,
    "armed": armed,
    "service": service,
    "instruments": instruments,
}


def results(window):
    """Show each state of a result, its places and their sheets, and the stick; name each."""
    page, node = window.result, window.node

    def shown(name):
        for _ in range(2):
            show(window, ENDED)
        return f"result {name}"

    def find(candidates=MANY, record=None, **changes):
        page.result.open("")
        search(page.result, node, candidates, record, **changes)
        show(window, ENDED)

    interrupted = stored(7, outcome="interrupted")
    take_list(window, (past_survey(survey_id=SURVEY, stored_traces=999999, planned_traces=10**6),))
    window.show_tab(TabName.SURVEY)
    page.result.open("")
    page.end()
    show(window, ENDED)
    node.ticket("read").done(interrupted)
    show(window, ENDED)
    node.ticket("focus").fail(REFUSED)
    yield shown("refused")
    find((), interrupted)
    yield shown("without places")
    find(record=interrupted, omitted=12345, notes=(REFUSED,))
    for _ in range(9):
        page.more.click()
    yield shown("last places")
    assert not [row.title.text() for row in page.rows[:3] if is_cut(row.title)]

    find()
    page.rows[4].click()
    sheet = page.place_sheet
    sheet._who, sheet._depth, sheet._what = "W" * 60, "1234.5", What.DEVICE
    sheet.show_now()
    yield shown("place")
    sheet.hide()
    page.soil.click()
    page.soil_sheet._choose(12.345)
    yield shown("soil")
    page.soil_sheet.hide()
    page.hiding.click()
    list(page.hiding_sheet.targets.values())[1].click()
    node.ticket("hide").done(a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY))
    yield shown("hiding")
    page.hiding_sheet.hide()

    page.stick.click()
    plug_in(node, BLUE, RED, LOCKED)
    yield shown("sticks")
    page.stick_sheet.sticks[1].click()
    node.ticket("export").progress(verbatim("copia a la memoria USB"))
    yield shown("export")
    node.ticket("export").done(Exported(("GPR20/a.pdf", "GPR20/b.zip")))
    yield shown("exported")
