"""Logging in and out, what a cookie is worth and for how long, and who waits that guesses."""

from __future__ import annotations

import contextlib
import random
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple

import pytest
import web_kit
from hypothesis import given
from hypothesis import strategies as st
from run_seed import SEED, draws
from web_kit import LONGEST_HOURS, OTHER_PASSWORD, PASSWORD, ManualClock, make_accounts, make_logins

from gpr20_common.message import Message
from gpr20_web.calls import Call, Cookie, Role
from gpr20_web.errors import (
    AccountsFileError,
    NotLoggedInError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.low import accounts as accounts_module
from gpr20_web.low.handlers import COOKIE
from gpr20_web.low.logins import Logins
from gpr20_web.mid import login_page
from gpr20_web.mid.login_page import FREE_FAILURES, PAUSE_S, LoginLimits, LoginPage

ADDRESS = "127.0.0.1"


class Pages:
    """The page LOGIN of a folder with two accounts."""

    def __init__(self, folder: Path) -> None:
        self.clock, self.accounts = ManualClock(), make_accounts(folder)
        for name, role in [("leo", Role.CONTROL), ("eva", Role.WATCH)]:
            self.accounts.put(name, role, PASSWORD)
        self.logins = make_logins(self.accounts, self.clock)
        self.page = LoginPage(self.accounts, self.logins, self.clock)

    def ask(self, path: str, values: Optional[Mapping[str, Any]] = None, cookie: str = "") -> Any:
        """Ask as the server does."""
        (route,) = [one for one in self.page.routes if one.pattern == path]
        person = None if route.right is Role.NOBODY else self.logins.find(cookie, ADDRESS)
        return route.answer(Call(person, ADDRESS, values or {}))

    def is_in(self, cookie: str) -> bool:
        try:
            return bool(self.logins.find(cookie, ADDRESS))
        except NotLoggedInError:
            return False

    def log_in(self, name: str = "leo", password: str = PASSWORD) -> str:
        answer = self.ask("/api/login", {"name": name, "password": password})
        assert isinstance(answer, Cookie)
        return answer.session


@pytest.fixture
def pages(tmp_path: Path) -> Pages:
    return Pages(tmp_path)


def test_a_login_gives_a_cookie_and_says_who_one_is(pages: Pages) -> None:
    answer = pages.ask("/api/login", {"name": "Leo", "password": PASSWORD})
    person = pages.logins.find(answer.session, ADDRESS)
    expected = {"name": "leo", "role": 2, "mark": person.mark}
    assert answer.values == expected == pages.ask("/api/me", cookie=answer.session)
    assert answer.session not in str(answer.values)
    # Two browsers of one person are two: one of them is in control.
    assert pages.logins.find(pages.log_in(), ADDRESS).mark != person.mark
    assert pages.ask("/api/logout", cookie=answer.session) == Cookie("")


def test_a_session_is_over_after_its_hours_and_when_its_account_has_changed(pages: Pages) -> None:
    cookie, eva = pages.log_in(), pages.log_in("eva")
    pages.clock.time_s += 3600.0 * LONGEST_HOURS - 1.0
    assert pages.is_in(cookie)
    # The node was restarted.
    pages.logins = make_logins(make_accounts(pages.accounts._folder.parent), pages.clock)
    assert pages.is_in(cookie)
    pages.clock.time_s += 2.0
    assert not pages.is_in(cookie)
    pages.clock.time_s -= 2.0
    pages.accounts.put("leo", Role.WATCH, OTHER_PASSWORD)
    assert [pages.is_in(one) for one in (cookie, eva)] == [False, True]
    cookie = pages.log_in(password=OTHER_PASSWORD)
    pages.accounts.remove("leo")
    assert not pages.is_in(cookie)
    pages.accounts.put("leo", Role.WATCH, OTHER_PASSWORD)
    assert not pages.is_in(cookie)


def test_who_has_logged_in_stays_so_while_the_file_of_the_accounts_is_damaged(
    pages: Pages, tmp_path: Path
) -> None:
    cookie = pages.log_in()
    (tmp_path / "web" / "accounts.json").write_text("damaged")
    assert pages.logins.find(cookie, ADDRESS).role is Role.CONTROL
    # Nobody has guessed.
    for _number in range(FREE_FAILURES + 1):
        with pytest.raises(AccountsFileError):
            pages.log_in()


def test_no_other_cookie_is_taken(pages: Pages) -> None:
    cookie, draw = pages.log_in(), random.Random(SEED)
    others = ["", "x", cookie[:-1], cookie + "0", cookie.upper(), "é\ud800"]
    other_key = Logins(pages.accounts, b"o" * 32, LONGEST_HOURS, pages.clock)
    others.append(other_key.begin(pages.accounts.all()[0]))
    for _number in range(draws(200)):
        at, sign = draw.randrange(len(cookie)), chr(draw.randrange(33, 127))
        others.append(cookie[:at] + sign + cookie[at + 1 :])
    assert [one for one in others if one != cookie and pages.is_in(one)] == []


def test_owasp_the_session_is_in_a_cookie_alone_chosen_here_and_out_of_reach_of_scripts(
    pages: Pages,
) -> None:
    login, chosen = {"name": "leo", "password": PASSWORD}, "chosen-by-somebody-else"
    site = web_kit.Site(pages.page.routes, find=pages.logins.find)
    with contextlib.closing(site):
        reply = site.ask("POST", "/api/login", login, session=chosen)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        session = cookie.coded_value
        assert reply.status == 200 and session != chosen
        assert site.ask("GET", "/api/me", session=chosen).status == 401
        assert cookie["secure"] and cookie["httponly"]
        assert (cookie["samesite"], cookie["path"]) == ("Strict", "/")
        assert cookie["domain"] == cookie["expires"] == ""
        assert session.encode() not in reply.body
        assert reply.headers["Cache-Control"] == "no-store"
        # In the address or the body it is none.
        for path in (f"/api/me?session={session}", f"/api/me?{COOKIE}={session}"):
            assert site.ask("GET", path).status == 401
        assert site.ask("POST", "/api/logout", {"session": session}).status == 401
        assert site.ask("GET", "/api/me", session=session).values["name"] == "leo"
        reply = site.ask("POST", "/api/logout", session=session)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        assert cookie.value == "" and "1970" in cookie["expires"]
    assert site.reported == []


def test_guesses_are_delayed_before_any_hash(pages: Pages, monkeypatch: pytest.MonkeyPatch) -> None:
    for _number in range(FREE_FAILURES):
        with pytest.raises(WrongLoginError):
            pages.log_in("eva", "guess")
    with monkeypatch.context() as patch:
        patch.setattr(accounts_module, "_key_of", lambda *_arguments: pytest.fail("it was hashed"))
        with pytest.raises(TooManyLoginsError, match="wait 60 s") as refused:
            pages.log_in("EVA")
    assert refused.value.status == 429
    assert pages.log_in()


STEPS = st.tuples(
    st.sampled_from(["ana", "eva"]),
    st.sampled_from(["here", "there"]),
    st.sampled_from([False, False, False, True]),
    st.sampled_from([0.0, 0.5, 30.0, 59.0, PAUSE_S, 300.0]),
)


def _try(limits: LoginLimits, right: bool, name: str, address: str) -> Optional[bool]:
    """Return whether a login succeeded; None: it was refused without a check."""
    try:
        with limits.attempt(name, address):
            if not right:
                raise WrongLoginError(Message("wrong"))
    except TooManyLoginsError:
        return None
    except WrongLoginError:
        return False
    return True


@given(st.lists(STEPS, max_size=60))
def test_random_logins_wait_as_long_as_a_simple_model_says(
    steps: List[Tuple[str, str, bool, float]],
) -> None:
    clock = ManualClock()
    limits = LoginLimits(clock)
    failures: Dict[Tuple[str, str], List[float]] = {}
    for name, address, right, time_s in steps:
        clock.time_s += time_s
        now_s, known = clock.time_s, failures.setdefault((name, address), [])
        early = len(known) >= FREE_FAILURES and now_s - known[-1] < PAUSE_S
        assert _try(limits, right, name, address) is (None if early else right)
        if right and not early:
            known.clear()
        elif not early:
            known.append(now_s)


def test_memory_is_bounded_and_the_one_that_failed_last_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(login_page, "MOST_KNOWN", 20)
    limits = LoginLimits(ManualClock())
    for number in range(30 * FREE_FAILURES):
        _try(limits, False, f"user{number // FREE_FAILURES}", ADDRESS)
    assert len(limits._failures) == 20
    assert _try(limits, True, "user29", ADDRESS) is None
