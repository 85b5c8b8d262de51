import dataclasses

import numpy as np
from view_kit import SURVEY, make_grid, trace_at

from gpr20_common.message import verbatim
from gpr20_operator.ground.trace_events import page_of_traces
from gpr20_survey.trace import trace_message

GRID = make_grid()


def message(index):
    return trace_message.encode(trace_at(GRID, index))


def with_a_nan(index):
    data = bytearray(message(index))
    numbers = trace_at(GRID, index).s21_real.tobytes()
    start = bytes(data).index(numbers)
    data[start : start + 8] = np.array([np.nan]).tobytes()
    return bytes(data)


def test_a_page_holds_the_traces_as_they_were_stored():
    without_height = dataclasses.replace(trace_at(GRID, 4), antennae_height_m=float("nan"))
    stored = [trace_at(GRID, 3), without_height]
    messages = [(one.index, trace_message.encode(one)) for one in stored]
    page = page_of_traces(SURVEY, 3, messages, {5: verbatim("torn")})
    assert (page.survey, page.first_index, page.unreadable) == (SURVEY, 3, {5: verbatim("torn")})
    assert [one.fingerprint() for one in page.traces] == [one.fingerprint() for one in stored]


def test_a_trace_that_is_not_allowed_is_named_and_leaves_the_others():
    for damaged in (b"", message(4)[:-9], message(4) + b"x", with_a_nan(4)):
        page = page_of_traces(SURVEY, 3, [(3, message(3)), (4, damaged)], {})
        assert [one.index for one in page.traces] == [3]
        assert list(page.unreadable) == [4]
        assert str(page.unreadable[4])
