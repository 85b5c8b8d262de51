"""Logging in and out, what a cookie is worth and for how long, and who waits that guesses."""

from __future__ import annotations

import contextlib
import random
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Dict, List, Optional, Tuple
from unittest import mock

import pytest
import web_kit
from run_seed import SEED, draws
from web_kit import LONGEST_HOURS, OTHER_PASSWORD, PASSWORD, ManualClock, make_accounts, make_logins

from gpr20_web.calls import Role
from gpr20_web.faults import (
    AccountsFileError,
    NotLoggedInError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.low import accounts
from gpr20_web.low.http_server import COOKIE
from gpr20_web.low.logins import FREE_FAILURES, PAUSE_S, Logins
from gpr20_web.mid.shell import Shell

ADDRESS = "127.0.0.1"


class Desk:
    """The logins of a folder with two accounts."""

    def __init__(self, folder: Path) -> None:
        self.clock, self.accounts = ManualClock(), make_accounts(folder)
        for name, role in [("leo", Role.CONTROL), ("eva", Role.WATCH)]:
            self.accounts.put(name, role, PASSWORD)
        self.logins = make_logins(self.accounts, self.clock)

    def is_in(self, cookie: str) -> bool:
        try:
            return bool(self.logins.find(cookie, ADDRESS))
        except NotLoggedInError:
            return False

    def log_in(self, name: str = "leo", password: str = PASSWORD) -> str:
        return self.logins.begin(name, password, ADDRESS).session

    def tries(self, right: bool, name: str, address: str) -> Optional[bool]:
        """Return whether a login succeeded; None: it was refused without a check."""
        try:
            self.logins.begin(name, PASSWORD if right else "guess", address)
        except TooManyLoginsError:
            return None
        except WrongLoginError:
            return False
        return True


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def test_a_session_is_over_after_its_hours_and_when_its_account_has_changed(desk: Desk) -> None:
    cookie, eva = desk.log_in(), desk.log_in("eva")
    desk.clock.time_s += 3600.0 * LONGEST_HOURS - 1.0
    assert desk.is_in(cookie)
    # The node was restarted.
    desk.logins = make_logins(make_accounts(desk.accounts._folder.parent), desk.clock)
    assert desk.is_in(cookie)
    desk.clock.time_s += 2.0
    assert not desk.is_in(cookie)
    desk.clock.time_s -= 2.0
    desk.accounts.put("leo", Role.WATCH, OTHER_PASSWORD)
    assert [desk.is_in(one) for one in (cookie, eva)] == [False, True]
    cookie = desk.log_in(password=OTHER_PASSWORD)
    desk.accounts.remove("leo")
    assert not desk.is_in(cookie)
    desk.accounts.put("leo", Role.WATCH, OTHER_PASSWORD)
    assert not desk.is_in(cookie)


def test_who_has_logged_in_stays_so_while_the_file_of_the_accounts_is_damaged(
    desk: Desk, tmp_path: Path
) -> None:
    cookie = desk.log_in()
    (tmp_path / "web" / "accounts.txt").write_text("damaged")
    assert desk.logins.find(cookie, ADDRESS).role is Role.CONTROL
    # Nobody has guessed.
    for _number in range(FREE_FAILURES + 1):
        with pytest.raises(AccountsFileError):
            desk.log_in()


def test_no_other_cookie_is_taken(desk: Desk) -> None:
    cookie, draw = desk.log_in(), random.Random(SEED)
    others = ["", "x", cookie[:-1], cookie + "0", cookie.upper(), "é\ud800"]
    other_key = Logins(desk.accounts, b"o" * 32, LONGEST_HOURS, desk.clock)
    others.append(other_key.begin("leo", PASSWORD, ADDRESS).session)
    for _number in range(draws(200)):
        at, sign = draw.randrange(len(cookie)), chr(draw.randrange(33, 127))
        others.append(cookie[:at] + sign + cookie[at + 1 :])
    assert [one for one in others if one != cookie and desk.is_in(one)] == []


def test_owasp_the_session_is_in_a_cookie_alone_chosen_here_and_out_of_reach_of_scripts(
    desk: Desk,
) -> None:
    login, chosen = {"name": "Leo", "password": PASSWORD}, "chosen-by-somebody-else"
    site = web_kit.Site(tuple(Shell({}, desk.logins).all_routes()), find=desk.logins.find)
    with contextlib.closing(site):
        reply = site.ask("POST", "/api/login", login, session=chosen)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        session = cookie.coded_value
        assert reply.status == 200 and session != chosen
        assert site.ask("GET", "/api/me", session=chosen).values == {"me": None}
        assert cookie["secure"] and cookie["httponly"]
        assert (cookie["samesite"], cookie["path"]) == ("Strict", "/")
        assert cookie["domain"] == cookie["expires"] == ""
        assert session.encode() not in reply.body
        me = {"name": "leo", "role": 2, "mark": desk.logins.find(session, ADDRESS).mark}
        assert reply.values == me == site.ask("GET", "/api/me", session=session).values["me"]
        # Two browsers of one person are two: one of them is in control.
        assert site.ask("POST", "/api/login", login).values["mark"] != me["mark"]
        # In the address or the body it is none.
        for path in (f"/api/me?session={session}", f"/api/me?{COOKIE}={session}"):
            assert site.ask("GET", path).values == {"me": None}
        assert site.ask("POST", "/api/logout", {"session": session}).status == 401
        reply = site.ask("POST", "/api/logout", session=session)
        cookie = SimpleCookie(reply.headers["Set-Cookie"])[COOKIE]
        assert cookie.value == "" and "1970" in cookie["expires"]
    assert site.reported == []


def test_the_memory_of_failures_is_bounded_and_keeps_the_last(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gpr20_web.low.logins.MOST_KNOWN", 3)
    for number in range(9 * FREE_FAILURES):
        assert desk.tries(False, f"user{number // FREE_FAILURES}", ADDRESS) is False
    assert len(desk.logins._failures) == 3 and desk.tries(False, "user8", ADDRESS) is None


def test_random_logins_wait_as_long_as_a_simple_model_says_before_any_hash(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw, hashed = random.Random(SEED), mock.Mock(side_effect=accounts.hash_of)
    monkeypatch.setattr(accounts, "hash_of", hashed)
    failures: Dict[Tuple[str, str], List[float]] = {}
    for _number in range(draws(500)):
        name, address = draw.choice(["leo", "LEO", "eva", "eve"]), draw.choice(["here", "there"])
        right = name != "eve" and draw.random() < 0.1  # who has no account
        desk.clock.time_s += draw.choice([0.0, 0.5, 5.0, 59.0, PAUSE_S])
        now_s, known = desk.clock.time_s, failures.setdefault((name.lower(), address), [])
        early = len(known) >= FREE_FAILURES and now_s - known[-1] < PAUSE_S
        assert desk.tries(right, name, address) is (None if early else right)
        assert hashed.called is not early
        hashed.reset_mock()
        if right and not early:
            known.clear()
        elif not early:
            known.append(now_s)
