"""Who may move an axis."""

from __future__ import annotations

import random

import pytest
from run_seed import SEED, draws

from gpr20_axis_driver.faults import AxisBusyError, LeaseLapsedError
from gpr20_axis_driver.mid.axis_lease import AxisLease
from gpr20_survey.faults import CONTROL_SILENT

LIMIT_S = 2.0
CONTROL, OTHER = "/main_control", "/rostopic_7"


class Time:
    now_s = 100.0


@pytest.fixture
def lease():
    return AxisLease(LIMIT_S, lambda: Time.now_s)


def test_whoever_asks_when_there_is_one_holder_until_it_releases_or_does_not_renew(lease):
    chance, holder, until_s, numbers = random.Random(SEED), "", 0.0, [0]
    for _ in range(draws(1000)):
        Time.now_s += chance.choice([0.0, 0.0, 0.5, 2.5])
        name, number = chance.choice([CONTROL, OTHER, "/play_9"]), chance.choice(numbers[-3:])
        live = holder if Time.now_s <= until_s else ""
        assert lease.owner == live
        held = (name, number) == (live, numbers[-1])
        act = chance.choice([lease.reserve, lease.renew, lease.release])
        if act == lease.reserve and live in ("", name):
            numbers.append(lease.reserve(name))
            assert numbers[-1] > numbers[-2]
            holder, until_s = name, Time.now_s + LIMIT_S
        elif act == lease.reserve:
            with pytest.raises(AxisBusyError, match=live):
                lease.reserve(name)
        elif act == lease.release:
            lease.release(name, number)
            holder = "" if held else holder
        elif held:
            lease.renew(name, number)
            until_s = Time.now_s + LIMIT_S
        else:
            with pytest.raises(LeaseLapsedError):
                lease.renew(name, number)


def test_a_motion_owns_the_axis_and_ends_with_the_lease_with_which_it_began(lease):
    with lease.use(OTHER) as why_ended:
        with pytest.raises(AxisBusyError, match=OTHER):
            lease.reserve(CONTROL)
        assert why_ended() is None and lease.owner == OTHER
    lease.reserve(CONTROL)
    with pytest.raises(AxisBusyError, match=CONTROL), lease.use(OTHER):
        raise AssertionError("refused")
    with lease.use(CONTROL, lambda: True) as why_ended:
        assert why_ended() is None
        Time.now_s += 1.1 * LIMIT_S
        assert why_ended().fault_code == CONTROL_SILENT.code
        assert lease.owner == CONTROL
        # Another lease is not that with which it began.
        lease.reserve(CONTROL)
        assert why_ended() is not None
    Time.now_s += 1.1 * LIMIT_S
    # Nobody would watch this motion.
    with pytest.raises(LeaseLapsedError), lease.use(CONTROL):
        raise AssertionError("refused")


def test_without_a_lease_a_motion_ends_when_its_client_was_gone_at_any_moment(lease):
    gone = iter([False, True, False, True])
    with lease.use(OTHER, lambda: next(gone)) as why_ended:
        assert [why_ended() is not None for _poll in range(3)] == [False, True, True]
        assert why_ended().fault_code == CONTROL_SILENT.code
