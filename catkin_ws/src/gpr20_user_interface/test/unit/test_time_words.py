import re

from hypothesis import given
from hypothesis import strategies as st

from gpr20_operator.robot.events import Progress
from gpr20_operator.words import duration, time_left
from gpr20_user_interface.terminal.displays import progress_line, remaining

DAY_S = 86400


def test_a_time_is_written_as_people_say_it():
    for time_s, text in (
        *((time_s, "less than 1 min") for time_s in (-3, 0, 59.9)),
        (60, "1 min"),
        (61, "2 min"),
        (1128, "19 min"),
        (3599.5, "1 h 0 min"),
        (3900, "1 h 5 min"),
        (DAY_S - 1, "1 d 0 h"),
        (2 * DAY_S + 3 * 3600 + 1, "2 d 4 h"),
    ):
        assert str(duration(time_s)) == text
        assert str(time_left(time_s)) == f"{text} left"


@given(st.integers(min_value=60, max_value=400 * DAY_S))
def test_a_time_is_rounded_up_by_less_than_its_last_unit(time_s):
    words = str(duration(time_s))
    units = {"d": DAY_S, "h": 3600, "min": 60}
    parts = re.findall(r"(\d+) (d|h|min)", words)
    said_s = sum(int(number) * units[unit] for number, unit in parts)
    assert 0 <= said_s - time_s < units[parts[-1][1]]


def test_time_that_is_left_says_what_it_is_based_on():
    for visited, basis in ((0, "by the plan"), (1, "measured"), (12, "measured")):
        progress = Progress("id", 0.0, 18, visited, 1128.0)
        assert str(remaining(progress)) == f"19 min left ({basis})"


def test_line_tells_percent_and_traces():
    line = str(progress_line(Progress("id", 66.6667, 18, 12, 60.0)))
    assert "66.7 %" in line and "12/18 traces" in line and "1 min left" in line
