"""Logging in and out, who waits that guesses, and users: by the table of routes, and a socket."""

from __future__ import annotations

import contextlib
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple

import pytest
import web_kit
from hypothesis import given
from hypothesis import strategies as st
from web_kit import OTHER_PASSWORD, PASSWORD, ManualClock, NoFile, Noted, make_accounts

from gpr20_common.message import Message
from gpr20_web.calls import Call, Cookie
from gpr20_web.errors import (
    AccountsFileError,
    BusyError,
    NotLoggedInError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.low.passwords import PasswordHash
from gpr20_web.low.table_handler import COOKIE
from gpr20_web.mid import login_limits
from gpr20_web.mid.login_limits import CHECKS_AT_ONCE, LoginLimits
from gpr20_web.mid.login_page import LoginPage
from gpr20_web.mid.sessions import Sessions
from gpr20_web.roles import Role

ADDRESS = "127.0.0.1"


class Pages:
    """The pages LOGIN and USERS of a folder with three accounts."""

    def __init__(self, folder: Path) -> None:
        self.clock, self.audit = ManualClock(), Noted()
        self.accounts = make_accounts(folder)
        for name, role in [("ana", Role.OPERATE), ("leo", Role.OPERATE), ("eva", Role.VIEW)]:
            self.accounts.add(name, role, PASSWORD)
        self.sessions = Sessions(self.accounts.find, self.clock, 1800.0, 43200.0, NoFile())
        login = LoginPage(self.accounts, self.sessions, LoginLimits(self.clock), self.audit)
        self.routes = login.routes

    def ask(
        self, method: str, path: str, values: Optional[Mapping[str, Any]] = None, token: str = ""
    ) -> Any:
        """Ask as the server does."""
        route, parts = web_kit.route_of(self.routes, method, path)
        person = None
        if route.right is not Role.NOBODY:
            person = self.sessions.find(token, ADDRESS)
            assert person.role >= route.right
        return route.answer(Call(person, ADDRESS, values or {}, parts))

    def is_in(self, token: str) -> bool:
        try:
            return bool(self.sessions.find(token, ADDRESS))
        except NotLoggedInError:
            return False

    def log_in(self, name: str = "leo", password: str = PASSWORD) -> str:
        answer = self.ask("POST", "/api/login", {"name": name, "password": password})
        assert isinstance(answer, Cookie)
        return answer.session


@pytest.fixture
def pages(tmp_path: Path) -> Pages:
    return Pages(tmp_path)


def test_a_login_gives_a_session_and_says_who_one_is(pages: Pages) -> None:
    answer = pages.ask("POST", "/api/login", {"name": "Leo", "password": PASSWORD})
    person = pages.sessions.find(answer.session, ADDRESS)
    expected = {"name": "leo", "role": 2, "mark": person.mark}
    assert answer.values == expected == pages.ask("GET", "/api/me", token=answer.session)
    assert answer.session not in str(answer.values)


def test_logins_failed_ones_and_logouts_are_in_the_audit_without_secrets(pages: Pages) -> None:
    with pytest.raises(WrongLoginError):
        pages.log_in("eva", OTHER_PASSWORD)
    with pytest.raises(WrongLoginError):
        pages.log_in("my secret password, in the wrong field", "x")
    pages.ask("POST", "/api/logout", token=pages.log_in())
    assert pages.audit.entries == [
        ("", "login", {"outcome": "web.wrong_login", "name": "eva"}),
        ("", "login", {"outcome": "web.wrong_login", "name": "?"}),
        ("leo", "login", {"outcome": "done"}),
        ("leo", "logout", {"outcome": "done"}),
    ]


def test_logouts_end_sessions_on_the_server(pages: Pages) -> None:
    one, other, eva = pages.log_in(), pages.log_in(), pages.log_in("eva")
    assert pages.ask("POST", "/api/logout", token=one) == Cookie("")
    assert [pages.is_in(token) for token in (one, other, eva)] == [False, True, True]
    one = pages.log_in()
    assert pages.ask("POST", "/api/logout_everywhere", token=other) == Cookie("")
    assert [pages.is_in(token) for token in (one, other, eva)] == [False, False, True]
    # So does another password.
    pages.accounts.change("eva", password=OTHER_PASSWORD)
    assert not pages.is_in(eva) and pages.is_in(pages.log_in("eva", OTHER_PASSWORD))


def test_guesses_are_delayed_before_any_hash(pages: Pages, monkeypatch: pytest.MonkeyPatch) -> None:
    for _number in range(5):
        with pytest.raises(WrongLoginError):
            pages.log_in("leo", "guess")
    monkeypatch.setattr(PasswordHash, "fits", lambda *_arguments: pytest.fail("it was hashed"))
    with pytest.raises(TooManyLoginsError):
        pages.log_in("leo", PASSWORD)


def test_owasp_the_token_is_in_a_cookie_alone_chosen_here_and_out_of_reach_of_scripts(
    pages: Pages,
) -> None:
    login, chosen = {"name": "leo", "password": PASSWORD}, "chosen-by-somebody-else"
    with contextlib.closing(web_kit.Site(pages.routes, find=pages.sessions.find)) as site:
        reply = site.ask("POST", "/api/login", login, session=chosen)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        token = cookie.value
        assert reply.status == 200 and token != chosen
        assert site.ask("GET", "/api/me", session=chosen).status == 401
        assert cookie["secure"] and cookie["httponly"]
        assert (cookie["samesite"], cookie["path"]) == ("Strict", "/")
        assert cookie["domain"] == cookie["expires"] == ""
        assert token.encode() not in reply.body
        assert reply.headers["Cache-Control"] == "no-store"
        # A token in the address or the body is none.
        for path in (f"/api/me?session={token}", f"/api/me?{COOKIE}={token}"):
            assert site.ask("GET", path).status == 401
        assert site.ask("POST", "/api/logout", {"session": token}).status == 401
        assert site.ask("GET", "/api/me", session=token).values["name"] == "leo"
        reply = site.ask("POST", "/api/logout", session=token)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        assert cookie.value == "" and "1970" in cookie["expires"]
        assert site.ask("GET", "/api/me", session=token).status == 401
    assert site.reported == []


class Tries:
    """Logs in and sees what becomes of it."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.limits = LoginLimits(self.clock)
        self.checked = 0

    def try_it(self, right: bool, name: str = "ana", address: str = ADDRESS) -> Optional[bool]:
        """Return whether the login succeeded; None: it was refused without a check."""
        try:
            with self.limits.attempt(name, address):
                if not right:
                    raise WrongLoginError(Message("wrong"))
        except TooManyLoginsError:
            return None
        except WrongLoginError:
            return False
        return True


def test_an_attempt_during_the_delay_says_the_seconds_and_checks_nothing() -> None:
    tries = Tries()
    # A name is the same in other letters.
    for name in ("ana", "Ana", "ANA", "ANa", "aNA"):
        assert tries.try_it(False, name) is False
    with pytest.raises(TooManyLoginsError, match="wait 60 s") as refused, tries.limits.attempt(
        "aNa", ADDRESS
    ):
        pytest.fail("it was checked")
    assert refused.value.status == 429
    # It was no failure either: the delay has not grown.
    tries.clock.time_s += 60.0
    assert tries.try_it(True) is True


def test_guesses_at_the_same_time_are_no_more_than_one_after_the_other() -> None:
    tries = Tries()
    for _number in range(2):
        tries.try_it(False)
    with contextlib.ExitStack() as stack:
        attempts = [tries.limits.attempt("ana", ADDRESS) for _number in range(3)]
        for one in attempts:
            stack.enter_context(one)
        assert tries.try_it(True) is None
        # In any order.
        for one in attempts:
            wrong = WrongLoginError(Message("wrong"))
            with contextlib.suppress(WrongLoginError):
                one.__exit__(WrongLoginError, wrong, None)
        stack.pop_all()
    assert tries.try_it(True) is None


def test_at_most_four_passwords_are_checked_at_the_same_time() -> None:
    tries = Tries()
    with contextlib.ExitStack() as stack:
        for number in range(CHECKS_AT_ONCE):
            stack.enter_context(tries.limits.attempt(f"user{number}", f"address{number}"))
        with pytest.raises(BusyError), tries.limits.attempt("ana", "here"):
            pytest.fail("it was checked")
    assert [tries.try_it(True, f"u{number}") for number in range(9)] == [True] * 9


def test_a_damaged_file_of_accounts_is_no_failure_and_forgives_none() -> None:
    tries = Tries()

    def try_damaged(name: str) -> None:
        with pytest.raises(AccountsFileError), tries.limits.attempt(name, ADDRESS):
            raise AccountsFileError(Message("damaged"))

    for _time in range(4):
        assert tries.try_it(False) is False
    for _time in range(2 * CHECKS_AT_ONCE):
        try_damaged("ana")
        try_damaged("eva")
    assert tries.try_it(False) is False
    assert tries.try_it(True) is None
    assert tries.try_it(True, "eva") is True and tries.try_it(True, "ana", "elsewhere") is True


def test_memory_is_bounded_and_the_one_that_failed_last_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(login_limits, "MOST_KNOWN", 20)
    tries = Tries()
    for number in range(30):
        for _time in range(5):
            tries.try_it(False, f"user{number}")
    assert len(tries.limits._failures) == 20
    assert tries.try_it(True, "user29") is None


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["ana", "eva"]),
            st.sampled_from(["here", "there"]),
            st.sampled_from([False, False, False, True]),
            st.sampled_from([0.0, 0.5, 30.0, 60.0]),
        ),
        max_size=40,
    )
)
def test_random_logins_wait_as_long_as_a_simple_model_says(
    steps: List[Tuple[str, str, bool, float]],
) -> None:
    tries = Tries()
    failed_s: Dict[object, List[float]] = {}
    for name, address, right, time_s in steps:
        tries.clock.time_s += time_s
        now_s = tries.clock.time_s
        times_s = failed_s.setdefault((name, address), [])
        early = len(times_s) >= 5 and now_s < times_s[-1] + 60.0
        assert tries.try_it(right, name, address) is (None if early else right)
        if right and not early:
            times_s.clear()
        elif not early:
            times_s.append(now_s)
