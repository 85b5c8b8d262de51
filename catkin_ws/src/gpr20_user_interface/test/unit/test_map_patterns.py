import itertools
import time

import numpy as np
import pytest
from test_look import contrast

from gpr20_operator.ground.coverage import StopState
from gpr20_user_interface.look.look import Mark, Theme
from gpr20_user_interface.pages.ground.map_canvas import INKS
from gpr20_user_interface.pages.ground.map_patterns import Ink, StopPattern


def inks_of(state, cell_px):
    pattern = StopPattern((1, 1), (cell_px, cell_px))
    return pattern.inks(np.array([[state]], np.uint8))


def test_two_states_differ_by_their_pattern_alone():
    """Whatever the colours are: which pixels have the same ink as their neighbour differs."""

    def shape(state, cell_px):
        inks = inks_of(state, cell_px)
        return inks != inks[0, -1]

    for cell_px in (4, 7, 15, 24, 60):
        for one, other in itertools.combinations(StopState, 2):
            differing = np.count_nonzero(shape(one, cell_px) != shape(other, cell_px))
            assert differing >= 0.05 * cell_px**2, (one, other, cell_px)


@pytest.mark.parametrize("theme", list(Theme))
def test_neighbouring_inks_differ_by_three_to_one(theme):
    marks = {mark: mark.of(theme) for mark in Mark}
    for state in (StopState.MISSING, StopState.PARTLY, StopState.FAILED):
        inks = {Ink(one) for one in np.unique(inks_of(state, 24))} - {Ink.GRID}
        assert len(inks) == 2, state
        assert contrast(*(marks[INKS[one]] for one in inks)) >= 3.0, state
    # Missing is empty, so that partly and done differ from it by their brightness.
    for one, other in (
        (Mark.STOP_PARTLY, Mark.PAPER),
        (Mark.STOP_DONE, Mark.STOP_PARTLY),
        (Mark.STOP_DONE, Mark.PAPER),
        (Mark.STOP_FAILED, Mark.PAPER),
    ):
        assert contrast(marks[one], marks[other]) >= 3.0, (one, other)


@pytest.mark.parametrize("shape", [(3, 3), (4, 5), (67, 67), (158, 158)])
@pytest.mark.parametrize("size", [(160, 150), (301, 299), (640, 600)])
def test_every_stop_has_its_place(shape, size):
    random_source = np.random.default_rng(shape[0] * size[0])
    states = random_source.integers(0, len(StopState), shape).astype(np.uint8)
    inks = StopPattern(shape, size).inks(states)
    assert inks.shape == (size[1], size[0])
    allowed = {
        StopState.MISSING: {Ink.PAPER, Ink.MISSING},
        StopState.PARTLY: {Ink.PARTLY, Ink.DONE},
        StopState.DONE: {Ink.DONE},
        StopState.FAILED: {Ink.FAILED, Ink.PAPER},
    }
    for row, column in random_source.integers(0, shape, (50, 2)):
        # One pixel inside of the stop's own edge.
        x, y = (int((one + 0.4) * px / n) for one, px, n in zip(
            (column, row), size, (shape[1], shape[0])))  # fmt: skip
        found = Ink(inks[y, x])
        own = int((y + 0.5) * shape[0] / size[1]), int((x + 0.5) * shape[1] / size[0])
        state = StopState(states[own])
        assert found in allowed[state] | {Ink.GRID}, (row, column)


@pytest.mark.parametrize("cells", [21, 158])
def test_a_changed_stop_is_drawn_in_a_few_milliseconds(cells):
    pattern = StopPattern((cells, cells), (640, 640))
    states = np.zeros((cells, cells), np.uint8)
    pattern.inks(states)
    begin_s = time.process_time()
    for _ in range(10):
        pattern.inks(states)
    assert (time.process_time() - begin_s) / 10 < 0.02
