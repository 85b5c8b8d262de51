"""How long somebody waits who guesses, and that nobody else does."""

from __future__ import annotations

import contextlib
from typing import Dict, List, Optional, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from login_kit import ManualClock

from gpr20_common.message import Message
from gpr20_web.errors import (
    AccountsFileError,
    BusyError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.mid import login_limits
from gpr20_web.mid.login_limits import CHECKS_AT_ONCE, FORGOTTEN_S, LoginLimits

NAME, ADDRESS = "ana", "10.0.0.7"


class Tries:
    """Logs in and sees what becomes of it."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.limits = LoginLimits(self.clock)
        self.checked = 0

    def try_it(self, right: bool, name: str = NAME, address: str = ADDRESS) -> Optional[bool]:
        """Return whether the login succeeded; None: it was refused without a check."""
        try:
            with self.limits.attempt(name, address):
                self.checked += 1
                if not right:
                    raise WrongLoginError(Message("wrong"))
        except TooManyLoginsError:
            return None
        except WrongLoginError:
            return False
        return True

    def wait_s(self, name: str = NAME, address: str = ADDRESS) -> float:
        """Return how long it refuses, in whole seconds, and let that time pass."""
        begun_s = self.clock.time_s
        with contextlib.suppress(WrongLoginError):
            while True:
                try:
                    with self.limits.attempt(name, address):
                        raise WrongLoginError(Message("wrong"))
                except TooManyLoginsError as error:
                    self.clock.time_s += float(error.message.values["seconds"])  # type: ignore
        return self.clock.time_s - begun_s


def test_three_failures_are_free_and_each_further_one_doubles_the_delay_to_300_s() -> None:
    tries = Tries()
    assert [tries.wait_s() for _number in range(14)] == [
        *(0, 0, 0),
        *(1, 2, 4, 8, 16, 32, 64, 128, 256),
        *(300, 300),
    ]


def test_an_attempt_during_the_delay_says_the_seconds_and_checks_nothing() -> None:
    tries = Tries()
    for _number in range(3):
        tries.try_it(False)
    with pytest.raises(TooManyLoginsError, match="wait 1 s") as refused, tries.limits.attempt(
        NAME, ADDRESS
    ):
        pytest.fail("it was checked")
    assert refused.value.status == 429
    assert "Wait as long as it says" in str(refused.value.message.remedy)
    assert tries.try_it(True) is None
    assert tries.checked == 3
    # It was no failure either: the delay has not grown.
    tries.clock.time_s += 1.0
    assert tries.try_it(True) is True


@pytest.mark.parametrize(
    "others",
    [[(NAME, f"10.0.0.{number}") for number in range(3)], [(f"u{n}", ADDRESS) for n in range(3)]],
)
def test_a_name_is_limited_from_every_address_and_an_address_for_every_name(
    others: List[Tuple[str, str]],
) -> None:
    tries = Tries()
    for name, address in others:
        assert tries.try_it(False, name, address) is False
    assert tries.try_it(True) is None
    assert tries.try_it(True, "eva", "10.0.0.99") is True


def test_a_name_is_the_same_in_other_letters() -> None:
    tries = Tries()
    for name in ("ana", "Ana", "ANA"):
        tries.try_it(False, name, f"address of {name}")
    assert tries.try_it(True, "aNa", "another") is None


def test_success_clears_the_name_but_not_the_address() -> None:
    tries = Tries()
    for number in range(3):
        assert tries.try_it(False, "ana", "here") is False
        assert tries.try_it(True, "ana", f"elsewhere {number}") is True
    assert tries.try_it(True, "ana", "elsewhere") is True
    assert tries.try_it(True, "eva", "here") is None


def test_who_guesses_elsewhere_keeps_nobody_out_who_has_logged_in_before() -> None:
    tries = Tries()
    assert tries.try_it(True) is True
    for number in range(12):
        tries.wait_s(NAME, f"guesser {number}")
    assert tries.try_it(True, NAME, "new") is None
    assert tries.try_it(True) is True
    # That was no help for those who guess.
    assert tries.try_it(False, NAME, "another guesser") is None


def test_an_address_that_has_logged_in_before_may_guess_no_faster() -> None:
    tries = Tries()
    assert tries.try_it(True) is True
    assert [tries.wait_s() for _number in range(6)] == [0, 0, 0, 1, 2, 4]
    assert tries.try_it(True, NAME, "new") is True


def test_success_adds_nothing_to_the_address() -> None:
    tries = Tries()
    assert [tries.try_it(True, f"user{number}") for number in range(20)] == [True] * 20


def test_failures_are_forgotten_after_an_hour_without_one() -> None:
    tries = Tries()
    for _number in range(6):
        tries.wait_s()
    tries.clock.time_s += FORGOTTEN_S
    assert [tries.try_it(False) for _number in range(4)] == [False, False, False, None]


def test_guesses_at_the_same_time_are_no_more_than_one_after_the_other() -> None:
    tries = Tries()
    for _number in range(2):
        tries.try_it(False)
    with tries.limits.attempt(NAME, "another address"), pytest.raises(
        TooManyLoginsError
    ), tries.limits.attempt(NAME, "a third address"):
        pytest.fail("it was checked")


def test_at_most_four_passwords_are_checked_at_the_same_time() -> None:
    tries = Tries()
    with contextlib.ExitStack() as stack:
        for number in range(CHECKS_AT_ONCE):
            stack.enter_context(tries.limits.attempt(f"user{number}", f"address{number}"))
        with pytest.raises(BusyError), tries.limits.attempt("ana", "here"):
            pytest.fail("it was checked")
    assert [tries.try_it(True, f"u{number}") for number in range(9)] == [True] * 9


def test_what_else_goes_wrong_frees_the_place_and_is_no_failure_of_the_address() -> None:
    tries = Tries()
    for number in range(2 * CHECKS_AT_ONCE):
        with pytest.raises(AccountsFileError), tries.limits.attempt(f"user{number}", ADDRESS):
            raise AccountsFileError(Message("damaged"))
    assert tries.try_it(True) is True


def test_memory_is_bounded_and_the_one_that_failed_last_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(login_limits, "MOST_KNOWN", 20)
    tries = Tries()
    for number in range(100):
        for _time in range(3):
            tries.try_it(False, f"user{number}", f"address{number}")
    for known in (tries.limits._names, tries.limits._addresses):
        assert len(known._known) == 20
    assert tries.try_it(True, "user99", "elsewhere") is None
    assert tries.try_it(True, "elsewho", "address99") is None
    assert tries.try_it(True, "x" * 60_000, "y") is True
    for number in range(100):
        assert tries.try_it(True, "eva", f"home {number}") is True
    assert len(tries.limits._succeeded) == 20


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["ana", "eva"]),
            st.sampled_from(["here", "there"]),
            st.booleans(),
            st.sampled_from([0.0, 0.5, 1.0, 3.0, 60.0, 300.0, 3600.0]),
        ),
        max_size=40,
    )
)
def test_random_logins_wait_as_long_as_a_simple_model_says(
    steps: List[Tuple[str, str, bool, float]],
) -> None:
    tries = Tries()
    model: Dict[object, List[float]] = {}
    succeeded = set()
    for name, address, right, time_s in steps:
        tries.clock.time_s += time_s
        now_s = tries.clock.time_s
        early = False
        login = (name, address) if (name, address) in succeeded else name
        for key in (login, address):
            times_s = model.setdefault(key, [])
            if times_s and now_s - times_s[-1] >= 3600.0:
                times_s.clear()
            if len(times_s) >= 3:
                early = early or now_s < times_s[-1] + min(300.0, 2.0 ** (len(times_s) - 3))
        assert tries.try_it(right, name, address) is (None if early else right)
        if early:
            continue
        if right:
            model[login].clear()
            succeeded.add((name, address))
        else:
            model[login].append(now_s)
            model[address].append(now_s)
