import dataclasses

import numpy as np
import pytest
from view_kit import SURVEY, make_grid, trace_at

from gpr20_common.message import verbatim
from gpr20_survey.trace import trace_message
from gpr20_user_interface.mid.trace_events import page_of_traces

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
    page = page_of_traces(SURVEY, 3, [(3, message(3)), (4, message(4))], {5: verbatim("torn")})
    assert (page.survey, page.first_index, page.unreadable) == (SURVEY, 3, {5: verbatim("torn")})
    expected = [trace_at(GRID, 3), trace_at(GRID, 4)]
    assert [one.fingerprint() for one in page.traces] == [one.fingerprint() for one in expected]


@pytest.mark.parametrize(
    "damaged", [b"", message(4)[:-9], message(4) + b"x", with_a_nan(4)], ids=lambda one: len(one)
)
def test_a_trace_that_is_not_allowed_is_named_and_leaves_the_others(damaged):
    page = page_of_traces(SURVEY, 3, [(3, message(3)), (4, damaged)], {})
    assert [one.index for one in page.traces] == [3]
    assert list(page.unreadable) == [4]
    assert str(page.unreadable[4])


def test_a_trace_keeps_its_bits_on_the_way_to_the_window():
    trace = dataclasses.replace(trace_at(GRID, 7), antennae_height_m=float("nan"))
    page = page_of_traces(SURVEY, 7, [(7, trace_message.encode(trace))], {})
    assert page.traces[0].fingerprint() == trace.fingerprint()
