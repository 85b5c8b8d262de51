"""A sweep is confirmed with its settings, by the instrument that made it, or not at all."""

from __future__ import annotations

import random
import threading
from typing import List

import pytest
from case_kit import each_case
from driver_bench import (
    ACCEPTED,
    ADDRESS,
    DATA,
    PREAMBLE,
    STATUS,
    TRIGGER,
    Bench,
    is_of_one_after,
    nothing,
)
from fault_kit import raises_fault
from run_seed import SEED, draws

from gpr20_survey.faults import VNA_REPLACED, VNA_SETTINGS
from gpr20_vna_acquisition.errors import VnaError, VnaReplacedError, VnaSettingError

CHECK_S = 5.0
# What somebody may set, beside what the driver sets.
HAND = {
    ":SENS:FREQ:STOP": "5000000000",
    ":SENS:SWE:POIN": "12",
    ":SENS:TRACE1:SPAR": "S11",
    ":SENS:TRACE1:DOM": "TIME",
    ":SENS:AVER:COUN": "4",
    ":SENS:SWE:IFBW": "20",
    ":SOUR:POW": "LOW",
    ":FORM": "ASC",
    ":INIT:CONT": "ON",
}


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


class AnyRequests:
    """Requests in any order, while somebody uses the instrument or pulls its cable."""

    def __init__(self, chance):
        self.chance, self.bench = chance, Bench(link_check_s=CHECK_S)
        self.driver = self.bench.driver
        self.has_address = self.is_set_up = self.is_gone = False
        self.made = {}
        # Of the sweep that was taken last: were its settings those of the set-up, and is it known
        # to be shown still, or not to be.
        self.number, self.was_right, self.is_shown, self.is_other_shown = 0, False, False, False
        self.is_proven = False

    def settings(self):
        return {header: self.bench.ask(f"{header}?") for header in HAND}

    def failure_of(self, action, *given):
        """Make a request; return its answer and None, or None and why it failed."""
        del self.bench.sent[:]
        try:
            return action(*given), None
        except VnaError as error:
            return None, error

    def take(self):
        before, number = self.settings(), self.bench.number
        found, failure = self.failure_of(self.driver.take_sweep)
        self.is_shown = failure is None
        assert (failure is None) == (self.is_set_up and not self.is_gone), failure
        # What kept its settings is not set up again: that may end its calibration.
        assert before != self.made or not self.is_set_up or self.bench.commands() <= {TRIGGER}
        if found is not None:
            (self.number, sweep), self.is_other_shown, self.is_proven = found, False, False
            self.was_right = self.settings() == self.made
            assert not self.was_right or is_of_one_after(sweep, number)

    def confirm(self, number):
        before, is_last, self.number = self.settings(), 0 < number == self.number, 0
        _found, failure = self.failure_of(self.driver.confirm, number)
        is_right = is_last and self.was_right and before == self.made and not self.is_gone
        assert failure is None or not is_right or not self.is_shown or self.is_other_shown
        assert failure is not None or (is_right and (self.is_proven or not self.is_other_shown))
        assert self.settings() == before, "nothing may be written to prove a sweep"

    def set_up(self):
        is_known = bool(self.driver.state.identity)
        accepted, failure = self.failure_of(self.driver.set_frequency_sweep, ACCEPTED)
        self.is_set_up, self.was_right = failure is None, False
        assert self.is_set_up == (is_known and not self.is_gone)
        if self.is_set_up:
            assert accepted == ACCEPTED and self.made in ({}, self.settings())
            self.made = self.settings()

    def connect(self):
        is_sure = self.is_gone or self.bench.before is nothing
        _identity, failure = self.failure_of(self.driver.connect_to_vna, ADDRESS)
        assert not is_sure or (failure is not None) == self.is_gone
        self.has_address, self.is_set_up, self.was_right = True, False, False

    def disconnect(self):
        is_left = self.driver.state.identity and self.bench.before is nothing
        self.driver.disconnect_from_vna()
        self.has_address = self.is_set_up = self.was_right = False
        assert not self.driver.state.linked and self.driver.trouble is None
        # It sweeps by itself again, and is left alone.
        alone = self.bench.vna.sweeper.runs_continuously and not self.bench.vna.instrument.is_remote
        assert alone or not is_left

    def ask_for_calibration(self):
        before = self.settings()
        if self.chance.random() < 0.5:
            self.break_once()
        _status, failure = self.failure_of(self.driver.check_calibration_status)
        assert (failure is None) == bool(self.driver.state.identity and not self.is_gone)
        # On a new link the data may have been read again.
        self.is_proven = self.is_proven or not self.is_other_shown
        # Settings that were made again hide that they were different.
        self.was_right = self.was_right and self.settings() == before

    def idle(self):
        before, is_sure = self.settings(), self.is_gone or self.bench.before is nothing
        # One in use is not disturbed.
        del self.bench.sent[:]
        self.driver.check_idle_link()
        assert self.bench.sent == []
        self.bench.clock.sleep_until_s(self.bench.clock.now_s() + CHECK_S)
        self.driver.check_idle_link()
        assert self.bench.commands() == set() and self.settings() == before
        found = self.driver.trouble is not None, self.driver.state.linked
        if not self.has_address:
            assert self.bench.sent == [] and found == (False, False)
        elif is_sure:
            assert found == (self.is_gone, not self.is_gone)

    def change_by_hand(self):
        header = self.chance.choice(list(HAND))
        self.bench.by_hand(f"{header} {HAND[header]}")
        self.is_other_shown |= header == ":INIT:CONT"

    def somebody_triggers(self):
        self.bench.by_hand(TRIGGER)
        self.is_other_shown = True

    def break_once(self):
        if not self.is_gone:
            self.bench.lose_link_once(self.chance.choice(["", TRIGGER, STATUS, DATA, PREAMBLE]))

    def pull_or_plug(self):
        self.is_gone = not self.is_gone
        self.bench.before = nothing
        if self.is_gone:
            self.bench.lose_links()

    def measure(self):
        """Take a sweep and confirm it; much may happen before and between."""
        if self.is_gone:
            self.pull_or_plug()
        if not self.driver.state.identity:
            self.connect()
        if not self.is_set_up:
            self.set_up()
        before, between = self.chance.choice([(0, 0), (0, 1), (1, 0), (1, 2), (0, 3)])
        self.meddle(before)
        self.take()
        number = self.number
        self.meddle(between)
        self.confirm(number)

    def meddle(self, count):
        acts = [self.take, self.set_up, self.connect, self.disconnect, self.pull_or_plug]
        acts += [self.somebody_triggers, self.idle, self.break_once]
        acts += [self.change_by_hand, self.ask_for_calibration] * 4
        for act in self.chance.sample(acts, count):
            act()
            assert self.bench.open_links == self.driver.state.linked


def test_whoever_uses_the_instrument_meanwhile_what_is_confirmed_was_measured_as_set_up():
    chance = random.Random(SEED)
    for _instrument in range(draws(20)):
        one = AnyRequests(chance)
        for _sweep in range(20):
            one.measure()


@each_case(
    "name, asked",
    [("TRACE_1_STOP_FREQ", ":SENS:FREQ:STOP"), ("TRACE_DOMAIN_TYPES", ":SENS:TRACE1:DOM")],
)
def test_what_a_preamble_does_not_say_is_asked_for(name, asked):
    bench = Bench()
    others = [name.encode(), b"DOMAIN"]

    def renamed(right: bytes) -> bytes:
        for one in others:
            right = right.replace(b"," + one + b"=", b"," + b"X" * len(one) + b"=")
        return right

    bench.answers(PREAMBLE, renamed)
    bench.configured()
    bench.driver.confirm(bench.taken)
    assert f"{asked}?" in bench.sent
    number = bench.taken
    bench.by_hand(f"{asked} {HAND[asked]}")
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.driver.confirm(number)


@each_case("name, value", [("SMOOTHING_PERCENT", 5), ("TRACE_MATH_TYPES", 1)])
def test_a_trace_that_the_instrument_processes_is_refused(name, value):
    def spoil(right: bytes) -> bytes:
        return right.replace(b"%s=0" % name.encode(), b"%s=%d" % (name.encode(), value))

    bench = Bench()
    bench.answers(PREAMBLE, spoil)
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.configured()
    bench.answers(PREAMBLE, lambda right: right)
    number = bench.configured().taken
    bench.answers(PREAMBLE, spoil)
    with raises_fault(VNA_SETTINGS, name, error=VnaSettingError):
        bench.driver.confirm(number)


def test_the_temperature_of_the_instrument_is_in_quarters_of_a_degree(bench):
    def temperature_c():
        return bench.driver.confirm(bench.taken).temperature_c

    assert temperature_c() == 40.0
    bench.answers(PREAMBLE, lambda right: right.replace(b"TURE=160", b"TURE= -6"))
    assert temperature_c() == -1.5
    # It is valid only with a calibration.
    bench.answers(PREAMBLE, lambda right: right.replace(b"CORRECTION=0", b"CORRECTION=1"))
    assert temperature_c() is None


# Links and instruments.


def test_another_serial_number_fails_the_request_at_once_until_it_is_connected(bench):
    bench.faults.set("OTHER_SERIAL")
    bench.lose_link_once()
    begun_s = bench.clock.now_s()
    with raises_fault(VNA_REPLACED, "SIMULATED-2"):
        bench.driver.get_trace()
    assert bench.clock.now_s() - begun_s < 3.0 and bench.open_links == 0
    assert "SIMULATED-2" in bench.driver.connect_to_vna(ADDRESS)
    assert bench.configured().is_new()


@each_case("says_its_serial_number", [True, False])
def test_another_instrument_on_the_same_link_is_noticed(says_its_serial_number):
    bench = Bench(unanswered_queries=() if says_its_serial_number else (PREAMBLE,))
    number = bench.configured().taken
    bench.faults.set("SWAPPED")
    with raises_fault(VNA_REPLACED, "SIMULATED-2", error=VnaReplacedError):
        bench.driver.confirm(number)
    with raises_fault(VNA_REPLACED, "SIMULATED-2"):
        bench.driver.take_sweep()


def test_exchanges_of_two_callers_do_not_mix(bench):
    found: List[bool] = []

    def measure() -> None:
        for _ in range(10):
            sweep = bench.driver.get_trace()
            found.append(len(set(sweep.s21_real)) == 1)

    threads = [threading.Thread(target=measure) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=30.0)
    assert found == [True] * 30
