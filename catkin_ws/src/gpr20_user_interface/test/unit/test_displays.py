import io

import pytest

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.low.terminal_bar import TerminalBar
from gpr20_user_interface.mid.displays import BarDisplay, PlainDisplay
from gpr20_user_interface.mid.events import ControlState, Progress

SURVEYING = ControlState(SurveyState.SURVEYING, "visiting", "id", True)
TOTAL = 200


def progress(visited):
    return Progress("id", 100.0 * visited / TOTAL, TOTAL, visited, float(TOTAL - visited))


def test_plain_lines_come_every_five_percent_and_at_the_end():
    stream = io.StringIO()
    display = PlainDisplay(stream)
    for visited in range(TOTAL + 1):
        display.show(progress(visited), SURVEYING)
    shown = [int(line.split("%")[1].split("/")[0]) for line in stream.getvalue().splitlines()]
    assert shown == list(range(0, TOTAL + 1, 10))


def test_plain_last_line_is_not_lost_below_five_percent():
    stream = io.StringIO()
    display = PlainDisplay(stream)
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
    display = BarDisplay(TerminalBar(stream))
    display.note("SURVEYING: visiting")
    display.show(progress(50), SURVEYING)
    display.close()
    text = stream.getvalue()
    assert "SURVEYING: visiting\n" in text
    last = text.rstrip("\n").split("\r")[-1]
    assert len(last) <= int(columns)
    for part in ("SIMULATED SURVEYING", "25%", "50/200", "0d:0h:2m:30s remaining (measured)"):
        assert part in last
    assert text.endswith("\n")


def test_bar_that_never_moved_leaves_no_trace():
    stream = io.StringIO()
    BarDisplay(TerminalBar(stream)).close()
    assert stream.getvalue() == ""
