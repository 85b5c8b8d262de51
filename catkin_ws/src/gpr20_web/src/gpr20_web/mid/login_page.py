"""Logging in and out, and how often somebody may guess."""

from __future__ import annotations

import contextlib
import math
import threading
from typing import Any, Dict, Iterator, Mapping, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.calls import Call, Cookie, Person, Role, Route, text_of
from gpr20_web.errors import TooManyLoginsError, WrongLoginError
from gpr20_web.low.accounts import Accounts
from gpr20_web.low.logins import Logins
from gpr20_web.mid.web_page import WebPage

# So many wrong passwords of one account and address; then each next try waits so long [s].
FREE_FAILURES, PAUSE_S = 5, 60.0
MOST_KNOWN = 1000


class LoginLimits:
    """Counts failed logins by account and address; any thread may use it.

    Who guesses elsewhere does not keep the owner of an account out.
    """

    def __init__(self, clock: Clock) -> None:
        self._now_s = clock.now_s
        self._lock = threading.Lock()
        # How many failed, and when the last one did; the one that failed longest ago is first.
        self._failures: Dict[Tuple[str, str], Tuple[int, float]] = {}

    @contextlib.contextmanager
    def attempt(self, name: str, address: str) -> Iterator[None]:
        """Check a password inside; WrongLoginError there is a failure, and success forgets all.

        Args:
            name: What was given, also if there is no such account.
            address: Where the request came from.

        Raises:
            TooManyLoginsError: It is too early; nothing was checked.
        """
        key = name.lower()[:40], address
        count, last_s = self._failures.get(key, (0, 0.0))
        wait_s = last_s + PAUSE_S - self._now_s()
        if count >= FREE_FAILURES and wait_s > 0.0:
            raise TooManyLoginsError(
                Message("too many logins failed; wait {seconds} s", seconds=math.ceil(wait_s))
            )
        try:
            yield
        except WrongLoginError:
            with self._lock:
                count, _last_s = self._failures.pop(key, (0, 0.0))
                self._failures[key] = count + 1, self._now_s()
                if len(self._failures) > MOST_KNOWN:
                    del self._failures[next(iter(self._failures))]
            raise
        with self._lock:
            self._failures.pop(key, None)


class LoginPage(WebPage):
    """The form in front of all other pages."""

    words: Mapping[str, Message] = {
        "name": Message("Name"),
        "password": Message("Password"),
        "log_in": Message("Log in"),
        "log_out": Message("Log out"),
    }

    def __init__(self, accounts: Accounts, logins: Logins, clock: Clock) -> None:
        self._accounts, self._logins, self._limits = accounts, logins, LoginLimits(clock)
        self.routes = (
            Route("POST", "/api/login", Role.NOBODY, self._log_in, blocking=True),
            Route("POST", "/api/logout", Role.WATCH, lambda _call: Cookie("")),
            Route("GET", "/api/me", Role.WATCH, lambda call: _me(call.who)),
        )

    def _log_in(self, call: Call) -> Cookie:
        name, password = text_of(call, "name"), text_of(call, "password")
        with self._limits.attempt(name, call.address):
            account = self._accounts.check(name, password)
        cookie = self._logins.begin(account)
        return Cookie(cookie, _me(Person(account.name, account.role, cookie, call.address)))


def _me(person: Person) -> Mapping[str, Any]:
    return {"name": person.name, "role": int(person.role), "mark": person.mark}
