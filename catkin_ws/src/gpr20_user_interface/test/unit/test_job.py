"""What is said of the survey that runs: percent, line, time left; in a terminal too."""

import io
from dataclasses import replace

import view_kit
from case_kit import each_case

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Progress, TargetPosition
from gpr20_operator.robot.job import JobScreen, area_of, line_of, percent_of, survey_name
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.terminal.displays import BarDisplay, PlainDisplay

HALF = Progress("id", 59.99, 18, 9, 1080.0)


def snapshot(code=None, **other):
    return view_kit.snapshot(code, **{"progress": HALF, **other})


def test_a_percentage_is_rounded_down_and_only_of_this_survey():
    assert percent_of(snapshot(SurveyState.SURVEYING)) == 59
    other = view_kit.state_of(SurveyState.SURVEYING, survey_id="other")
    for without in (snapshot(state=other), snapshot(SurveyState.CONFIGURED)):
        assert percent_of(without) is None


@each_case("low,high", [(50.0, 130.0), (130.0, 50.0)])
def test_the_line_is_that_of_the_target(low, high):
    plan = replace(default_parameters(), y_start_mm=low, y_stop_mm=high, y_points=5)
    for number in range(5):
        target = TargetPosition(1.0, low + (high - low) * number / 4, 0.0)
        now = snapshot(SurveyState.SURVEYING, target=target, job_parameters=plan)
        assert str(line_of(now)) == f"line {number + 1} of 5"
    assert "80 mm" in str(area_of(plan))
    assert line_of(snapshot(SurveyState.PAUSED, job_parameters=plan)) is None


def test_the_job_stays_until_the_next_survey_is_planned():
    screen = JobScreen()
    ended, running = snapshot(SurveyState.FINISHED), snapshot(SurveyState.SURVEYING)
    stopped = snapshot(SurveyState.STOPPED)
    for now, left, visible in (
        *((snapshot(SurveyState.IDLE), False, False), (running, True, True)),
        *((stopped, False, True), (ended, True, False), (ended, False, False)),
        # The same survey, resumed.
        *((running, False, True), (ended, False, True)),
    ):
        screen.note(now)
        if left:
            screen.leave(now)
        assert screen.visible is visible


def test_a_name_is_read_from_a_description_whatever_it_holds():
    named = '{"survey_id": "7", "annotation": {"name": "A", "site": "B"}}'
    assert survey_name(named) == ("7", "A")
    for text in ("", "[]", '{"annotation": null}', '{"annotation": {}}'):
        assert survey_name(text) == ("", "")


def show(display, visited):
    progress = Progress("id", visited / 2.0, 200, visited, 200.0 - visited)
    display.show(progress, view_kit.state_of(SurveyState.SURVEYING))


def test_plain_lines_come_every_ten_percent_and_at_the_end_in_the_language_of_the_terminal():
    stream = io.StringIO()
    display = PlainDisplay(stream, read_catalogue(Language.SPANISH))
    display.note(Message("permission denied", details="[Errno 13] '/data'"))
    for visited in (*range(196), 199, 200, 200):
        show(display, visited)
    noted, *shown = stream.getvalue().splitlines()
    assert noted == "permiso denegado ([Errno 13] '/data')"
    assert shown[3] == " 30.0 %  60/200 trazas  quedan 3 min (según lo medido)"
    assert [one.split("%")[0].strip() for one in shown] == [
        f"{10.0 * one:.1f}" for one in range(11)
    ]


@each_case("columns", [80, 200])
def test_the_bar_carries_everything_within_the_width_of_the_terminal(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    stream = io.StringIO()
    display = BarDisplay(stream, Catalogue())
    display.note(verbatim("SURVEYING: visiting"))
    show(display, 50)
    display.close()
    text = stream.getvalue()
    assert "SURVEYING: visiting\n" in text and text.endswith("\n")
    last = text.rstrip("\n").split("\r")[-1]
    assert len(last) <= columns
    for part in ("SIMULATED SURVEYING", "25%", "50/200", "3 min left (measured)"):
        assert part in last
