"""Logging in and out, as the table of routes asks for it; cookies and headers over a socket."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, Mapping, Optional

import pytest
import web_kit
from hypothesis import given
from hypothesis import strategies as st
from login_kit import OTHER_PASSWORD, PASSWORD, ManualClock, NoFile, Noted, make_accounts

from gpr20_common.errors import Gpr20Error
from gpr20_web.calls import Call, Cookie, Route
from gpr20_web.errors import (
    AccountError,
    AccountsFileError,
    BadRequestError,
    NotLoggedInError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.low.passwords import PasswordHash
from gpr20_web.low.table_handler import COOKIE
from gpr20_web.mid.login_limits import LoginLimits
from gpr20_web.mid.login_page import LoginPage
from gpr20_web.mid.sessions import Sessions
from gpr20_web.mid.users_page import UsersPage
from gpr20_web.roles import Role

ADDRESS = "127.0.0.1"


class Pages:
    """The pages LOGIN and USERS of a folder with three accounts."""

    def __init__(self, folder: Path, view_may_stop: bool = False) -> None:
        self.clock, self.audit = ManualClock(), Noted()
        self.accounts = make_accounts(folder)
        for name, role in [("ana", Role.ADMIN), ("leo", Role.OPERATE), ("eva", Role.VIEW)]:
            self.accounts.add(name, role, PASSWORD)
        self.sessions = Sessions(self.accounts.find, self.clock, 1800.0, 43200.0, NoFile())
        login = LoginPage(
            self.accounts, self.sessions, LoginLimits(self.clock), self.audit, view_may_stop
        )
        users = UsersPage(self.accounts, self.audit)
        self.routes = (*login.routes, *users.routes)

    def ask(
        self, method: str, path: str, values: Optional[Mapping[str, Any]] = None, token: str = ""
    ) -> Any:
        """Ask as the server does."""
        for route in self.routes:
            parts = route.match(path) if route.method == method else None
            if parts is not None:
                break
        else:
            raise LookupError(path)
        person = None
        if route.right is not Role.NOBODY:
            person = self.sessions.find(token, ADDRESS)
            assert person.role >= route.right
        return route.answer(Call(person, ADDRESS, values or {}, parts))

    def log_in(self, name: str = "leo", password: str = PASSWORD) -> str:
        """Return the token of a new session."""
        answer = self.ask("POST", "/api/login", {"name": name, "password": password})
        assert isinstance(answer, Cookie)
        return answer.session


@pytest.fixture
def pages(tmp_path: Path) -> Pages:
    return Pages(tmp_path)


def test_a_login_gives_a_session_and_says_who_one_is(pages: Pages) -> None:
    answer = pages.ask("POST", "/api/login", {"name": "Leo", "password": PASSWORD})
    person = pages.sessions.find(answer.session, ADDRESS)
    expected = {"name": "leo", "role": 2, "mark": person.mark, "may_stop": True}
    assert answer.values == expected == pages.ask("GET", "/api/me", token=answer.session)
    assert answer.session not in str(answer.values)


def test_who_watches_may_stop_if_the_site_says_so(tmp_path: Path) -> None:
    for may, folder in [(True, tmp_path / "a"), (False, tmp_path / "b")]:
        folder.mkdir()
        pages = Pages(folder, may)
        assert pages.ask("GET", "/api/me", token=pages.log_in("eva"))["may_stop"] is may


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


def test_guessing_is_delayed_before_any_hash(pages: Pages, monkeypatch: pytest.MonkeyPatch) -> None:
    for _number in range(3):
        with pytest.raises(WrongLoginError):
            pages.log_in("eva", "guess")
    monkeypatch.setattr(PasswordHash, "fits", lambda *_arguments: pytest.fail("it was hashed"))
    with pytest.raises(TooManyLoginsError):
        pages.log_in("eva", PASSWORD)


def test_owasp_session_fixation_the_token_changes_at_login_and_with_the_password(
    pages: Pages,
) -> None:
    tokens = [pages.log_in(), pages.log_in()]
    changed = pages.ask(
        "POST", "/api/password", {"old": PASSWORD, "new": OTHER_PASSWORD}, tokens[0]
    )
    assert len({*tokens, changed.session}) == 3
    for one in tokens:
        with pytest.raises(NotLoggedInError):
            pages.sessions.find(one, ADDRESS)
    assert pages.ask("GET", "/api/me", token=changed.session) == changed.values
    assert pages.log_in("leo", OTHER_PASSWORD)
    with pytest.raises(WrongLoginError):
        pages.log_in("leo", PASSWORD)


def test_owasp_logout_and_logout_everywhere_end_sessions_on_the_server(pages: Pages) -> None:
    first, second, third = (pages.log_in() for _number in range(3))
    other = pages.log_in("eva")
    assert pages.ask("POST", "/api/logout", token=first) == Cookie("")
    with pytest.raises(NotLoggedInError):
        pages.ask("GET", "/api/me", token=first)
    assert pages.ask("POST", "/api/logout_everywhere", token=second) == Cookie("")
    for one in (second, third):
        with pytest.raises(NotLoggedInError):
            pages.ask("GET", "/api/me", token=one)
    assert pages.ask("GET", "/api/me", token=other)["name"] == "eva"


def test_the_old_password_is_needed_and_its_guesses_are_delayed_too(pages: Pages) -> None:
    token = pages.log_in()
    for _number in range(3):
        with pytest.raises(AccountError, match="present password") as refused:
            pages.ask("POST", "/api/password", {"old": "guess", "new": OTHER_PASSWORD}, token)
        # The browser leaves the page at 401.
        assert refused.value.status == 400
    with pytest.raises(TooManyLoginsError):
        pages.ask("POST", "/api/password", {"old": PASSWORD, "new": OTHER_PASSWORD}, token)
    assert pages.accounts.check("leo", PASSWORD)


def test_a_bad_new_password_is_refused_and_changes_nothing(pages: Pages) -> None:
    token = pages.log_in()
    with pytest.raises(AccountError, match="12 to 200"):
        pages.ask("POST", "/api/password", {"old": PASSWORD, "new": "short"}, token)
    assert pages.ask("GET", "/api/me", token=token)["name"] == "leo"


def test_a_damaged_file_lets_nobody_in_and_puts_nobody_out_who_may_have_to_stop_the_robot(
    pages: Pages, tmp_path: Path
) -> None:
    token = pages.log_in()
    (tmp_path / "web" / "accounts.json").write_text("{}")
    with pytest.raises(AccountsFileError):
        pages.log_in("ana")
    assert pages.ask("GET", "/api/me", token=token)["name"] == "leo"


def test_an_administrator_makes_changes_and_removes_users_and_the_audit_says_so(
    pages: Pages,
) -> None:
    token = pages.log_in("ana")
    pages.audit.entries.clear()
    made = {"name": "Tom", "role": "view", "password": PASSWORD}
    listed = pages.ask("POST", "/api/users", made, token)["users"]
    assert [one["name"] for one in listed] == ["ana", "eva", "leo", "tom"]
    assert set(listed[0]) == {"name", "role", "created"}
    tom = pages.log_in("tom")
    pages.ask("POST", "/api/users/tom", {"role": "operate"}, token)
    with pytest.raises(NotLoggedInError):
        pages.sessions.find(tom, ADDRESS)
    pages.ask("POST", "/api/users/tom", {"password": OTHER_PASSWORD}, token)
    tom = pages.log_in("tom", OTHER_PASSWORD)
    left = pages.ask("DELETE", "/api/users/tom", token=token)
    assert left == pages.ask("GET", "/api/users", token=token)
    with pytest.raises(NotLoggedInError):
        pages.sessions.find(tom, ADDRESS)
    assert [one for one in pages.audit.entries if one[1] != "login"] == [
        ("ana", "add_user", {"outcome": "done", "name": "tom", "role": "view"}),
        (
            "ana",
            "change_user",
            {"outcome": "done", "name": "tom", "role": "operate", "password": False},
        ),
        (
            "ana",
            "change_user",
            {"outcome": "done", "name": "tom", "role": "operate", "password": True},
        ),
        ("ana", "remove_user", {"outcome": "done", "name": "tom"}),
    ]


def test_the_last_administrator_stays_on_the_page(pages: Pages) -> None:
    token = pages.log_in("ana")
    with pytest.raises(AccountError, match="last administrator"):
        pages.ask("DELETE", "/api/users/ana", token=token)
    with pytest.raises(AccountError, match="last administrator"):
        pages.ask("POST", "/api/users/ana", {"role": "view"}, token)
    assert pages.ask("GET", "/api/me", token=token)["role"] == 3


def test_only_administrators_reach_the_accounts(pages: Pages) -> None:
    users = [one for one in pages.routes if one.pattern.startswith("/api/users")]
    assert len(users) == 4
    assert {one.right for one in users} == {Role.ADMIN}
    open_ones = [one.pattern for one in pages.routes if one.right is Role.NOBODY]
    assert open_ones == ["/api/login"]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text() | st.text(st.characters()),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
)
KEYS = st.sampled_from(["name", "password", "role", "old", "new", "x"])
VALUES = st.dictionaries(KEYS, JSON | st.sampled_from([PASSWORD, "ana", "view", "admin"]))
PATHS = st.sampled_from(
    [
        ("POST", "/api/login"),
        ("POST", "/api/password"),
        ("GET", "/api/users"),
        ("POST", "/api/users"),
        ("POST", "/api/users/leo"),
        ("POST", "/api/users/..%2f"),
        ("DELETE", "/api/users/ana"),
        ("DELETE", "/api/users/Ñandú"),
    ]
)


@given(st.lists(st.tuples(PATHS, VALUES), max_size=6))
def test_whatever_is_sent_is_refused_with_an_error_of_the_project(
    tmp_path_factory: pytest.TempPathFactory, requests: list
) -> None:
    pages = Pages(tmp_path_factory.mktemp("fuzz"))
    for (method, path), values in requests:
        try:
            pages.ask(method, path, values, pages.log_in("ana"))
        except (Gpr20Error, AssertionError) as error:
            # Somebody may have changed the password of ana by chance: then all is as it should.
            assert isinstance(error, Gpr20Error)


@pytest.fixture
def site(pages: Pages) -> Iterator[web_kit.Site]:
    made = web_kit.Site(pages.routes, find=pages.sessions.find)
    yield made
    made.close()
    assert made.reported == []


def _cookie(reply: web_kit.Reply) -> Dict[str, str]:
    parts = [one.strip().partition("=") for one in reply.headers["Set-Cookie"].split(";")]
    return {name.lower(): value for name, _equal, value in parts}


def test_owasp_cookie_only_the_token_is_nowhere_else_and_scripts_cannot_read_it(
    site: web_kit.Site,
) -> None:
    reply = site.ask("POST", "/api/login", {"name": "leo", "password": PASSWORD})
    cookie = _cookie(reply)
    token = cookie[COOKIE.lower()]
    assert reply.status == 200
    assert {"secure", "httponly"} <= set(cookie)
    assert (cookie["samesite"], cookie["path"]) == ("Strict", "/")
    assert "domain" not in cookie and "expires" not in cookie
    assert token.encode() not in reply.body
    assert reply.headers["Cache-Control"] == "no-store"
    # A token in the address or the body is none.
    for path in (f"/api/me?session={token}", f"/api/me?{COOKIE}={token}"):
        assert site.ask("GET", path).status == 401
    assert site.ask("POST", "/api/logout", {"session": token}).status == 401
    assert site.ask("GET", "/api/me", session=token).values["name"] == "leo"


def test_owasp_logout_the_browser_forgets_the_cookie_and_the_server_the_session(
    site: web_kit.Site,
) -> None:
    reply = site.ask("POST", "/api/login", {"name": "leo", "password": PASSWORD})
    token = _cookie(reply)[COOKIE.lower()]
    cookie = _cookie(site.ask("POST", "/api/logout", session=token))
    assert cookie[COOKIE.lower()].strip('"') == ""
    assert site.ask("GET", "/api/me", session=token).status == 401


def test_owasp_fixation_a_token_that_the_browser_brings_is_never_taken(site: web_kit.Site) -> None:
    login = {"name": "leo", "password": PASSWORD}
    reply = site.ask("POST", "/api/login", login, session="chosen-by-somebody-else")
    assert _cookie(reply)[COOKIE.lower()] != "chosen-by-somebody-else"
    assert site.ask("GET", "/api/me", session="chosen-by-somebody-else").status == 401


@pytest.mark.parametrize("origin", [None, "https://evil.example", "null"])
def test_owasp_csrf_another_page_can_neither_log_in_nor_out(
    site: web_kit.Site, origin: Optional[str]
) -> None:
    login = {"name": "leo", "password": PASSWORD}
    assert site.ask("POST", "/api/login", login, headers={"Origin": origin}).status == 403
    token = _cookie(site.ask("POST", "/api/login", login))[COOKIE.lower()]
    reply = site.ask("POST", "/api/logout", session=token, headers={"Origin": origin})
    assert reply.status == 403
    assert site.ask("GET", "/api/me", session=token).status == 200


def test_unused_routes_are_not_there(pages: Pages) -> None:
    assert all(isinstance(one, Route) for one in pages.routes)
    with pytest.raises(LookupError):
        pages.ask("GET", "/api/login")
    with pytest.raises(BadRequestError):
        pages.ask("POST", "/api/users/leo", {}, pages.log_in("ana"))
