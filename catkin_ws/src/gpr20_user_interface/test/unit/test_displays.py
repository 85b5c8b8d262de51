import io

import pytest

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_common.message import Message, verbatim
from gpr20_operator.robot.events import ControlState, Progress
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.terminal.displays import BarDisplay, PlainDisplay

SURVEYING = ControlState(SurveyState.SURVEYING, verbatim("visiting"), "id", True)
TOTAL = 200
ENGLISH = Catalogue()
SPANISH = read_catalogue(Language.SPANISH)


def progress(visited):
    return Progress("id", 100.0 * visited / TOTAL, TOTAL, visited, float(TOTAL - visited))


def test_plain_lines_come_every_ten_percent_and_at_the_end():
    stream = io.StringIO()
    display = PlainDisplay(stream, ENGLISH)
    for visited in range(TOTAL + 1):
        display.show(progress(visited), SURVEYING)
    shown = [int(line.split("%")[1].split("/")[0]) for line in stream.getvalue().splitlines()]
    assert shown == list(range(0, TOTAL + 1, 20))


def test_plain_last_line_is_not_lost_below_ten_percent():
    stream = io.StringIO()
    display = PlainDisplay(stream, ENGLISH)
    for visited in (194, 199, 200, 200):
        display.show(progress(visited), SURVEYING)
    assert [line.split("%")[0].strip() for line in stream.getvalue().splitlines()] == [
        "97.0",
        "100.0",
    ]


@pytest.mark.parametrize("columns", ["80", "200"])
def test_bar_carries_everything_within_the_width_of_the_terminal(columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", columns)
    stream = io.StringIO()
    display = BarDisplay(stream, ENGLISH)
    display.note(verbatim("SURVEYING: visiting"))
    display.show(progress(50), SURVEYING)
    display.close()
    text = stream.getvalue()
    assert "SURVEYING: visiting\n" in text
    last = text.rstrip("\n").split("\r")[-1]
    assert len(last) <= int(columns)
    for part in ("SIMULATED SURVEYING", "25%", "50/200", "3 min left (measured)"):
        assert part in last
    assert text.endswith("\n")


def test_bar_that_never_moved_leaves_no_trace_and_one_that_moved_has_the_language():
    stream = io.StringIO()
    display = BarDisplay(stream, SPANISH)
    display.close()
    assert stream.getvalue() == ""
    display.show(progress(50), SURVEYING)
    display.close()
    assert "SIMULADO MIDIENDO" in stream.getvalue()


def test_lines_are_in_the_language_of_the_terminal_with_the_details_behind_them():
    stream = io.StringIO()
    display = PlainDisplay(stream, SPANISH)
    message = Message("Stop not accepted: {reason}", reason=Message("no answer in time"))
    display.note(message)
    display.note(Message("permission denied", details="[Errno 13] Permission denied: '/data'"))
    display.show(progress(50), SURVEYING)
    assert stream.getvalue().splitlines() == [
        "No se aceptó la orden de detener: no hubo respuesta a tiempo",
        "permiso denegado ([Errno 13] Permission denied: '/data')",
        " 25.0 %  50/200 trazas  quedan 3 min (según lo medido)",
    ]
