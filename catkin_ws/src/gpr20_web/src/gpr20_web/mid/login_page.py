"""Logging in and out, and how often somebody may guess."""

from __future__ import annotations

import contextlib
import math
import threading
from collections import OrderedDict
from typing import Any, Iterator, Mapping, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.calls import Call, Cookie, Person, Role, Route, text_of
from gpr20_web.errors import AccountsFileError, TooManyLoginsError
from gpr20_web.low.accounts import Accounts
from gpr20_web.low.cookies import Logins
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
        # How many failed, and when the last one began; the one that failed longest ago is first.
        self._failures: OrderedDict[Tuple[str, str], Tuple[int, float]] = OrderedDict()

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
        with self._lock:
            now_s = self._now_s()
            count, last_s = self._failures.get(key, (0, now_s))
            if count >= FREE_FAILURES and now_s - last_s < PAUSE_S:
                raise TooManyLoginsError(
                    Message(
                        "too many logins failed; wait {seconds} s",
                        seconds=math.ceil(last_s + PAUSE_S - now_s),
                    )
                )
            # Before it has failed: several at once would else be several guesses.
            self._put(key, (count + 1, now_s))
        try:
            yield
        except AccountsFileError:
            # Nobody has guessed.
            with self._lock:
                count, _last_s = self._failures.get(key, (1, now_s))
                self._put(key, (count - 1, last_s))
            raise
        with self._lock:
            self._failures.pop(key, None)

    def _put(self, key: Tuple[str, str], value: Tuple[int, float]) -> None:
        self._failures.pop(key, None)
        self._failures[key] = value
        if len(self._failures) > MOST_KNOWN:
            self._failures.popitem(last=False)


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
