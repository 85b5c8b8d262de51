import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_user_interface.mid.displays import progress_line, remaining, time_text
from gpr20_user_interface.mid.events import Progress

DAY_S = 86400


@pytest.mark.parametrize(
    ("time_s", "text"),
    [
        (1128, "0d:0h:18m:48s"),
        (0, "0d:0h:0m:0s"),
        (-3, "0d:0h:0m:0s"),
        (0.2, "0d:0h:0m:1s"),
        (3599.5, "0d:1h:0m:0s"),
        (DAY_S, "1d:0h:0m:0s"),
        (2 * DAY_S + 3 * 3600 + 4 * 60 + 5, "2d:3h:4m:5s"),
    ],
)
def test_time_is_written_as_operators_know_it(time_s, text):
    assert time_text(time_s) == text


@given(st.integers(min_value=0, max_value=400 * DAY_S))
def test_the_parts_of_a_time_make_the_time_again(time_s):
    days, hours, minutes, seconds = map(int, re.findall(r"\d+", time_text(time_s)))
    assert hours < 24 and minutes < 60 and seconds < 60
    assert ((days * 24 + hours) * 60 + minutes) * 60 + seconds == time_s


@pytest.mark.parametrize(
    ("visited", "basis"), [(0, "by the plan"), (1, "measured"), (12, "measured")]
)
def test_remaining_time_says_what_it_is_based_on(visited, basis):
    progress = Progress("id", 0.0, 18, visited, 1128.0)
    assert str(remaining(progress)) == f"0d:0h:18m:48s remaining ({basis})"


def test_line_tells_percent_and_traces():
    line = str(progress_line(Progress("id", 66.6667, 18, 12, 60.0)))
    assert "66.7 %" in line and "12/18 traces" in line and "0d:0h:1m:0s remaining" in line
