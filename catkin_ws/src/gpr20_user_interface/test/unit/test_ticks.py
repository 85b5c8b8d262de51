import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_user_interface.pages.ground.plots import round_ticks


@given(st.floats(-1000.0, 1000.0), st.floats(0.1, 5000.0), st.integers(2, 12))
def test_ticks_are_round_few_and_within_the_axis(low, span, most):
    ticks = round_ticks(low, low + span, most)
    assert len(ticks) <= most
    assert ((ticks >= low - 1e-6 * span) & (ticks <= low + span * (1 + 1e-6))).all()
    if len(ticks) > 1:
        step = ticks[1] - ticks[0]
        leading = step / 10.0 ** np.floor(np.log10(step * (1 + 1e-9)))
        assert min(abs(leading - one) for one in (1.0, 2.0, 5.0, 10.0)) < 1e-6


@pytest.mark.parametrize("axis", [(0.0, 0.0), (5.0, 1.0), (0.0, float("nan"))])
def test_an_axis_without_length_has_no_ticks(axis):
    assert not round_ticks(*axis, 5).size


def test_a_depth_axis_reads_in_hundreds():
    assert round_ticks(-50.0, 350.0, 6).tolist() == [0.0, 100.0, 200.0, 300.0]
