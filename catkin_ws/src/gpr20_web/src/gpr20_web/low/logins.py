"""Logging in, and who is logged in: that is what tornado has signed in each browser's cookie."""

from __future__ import annotations

import json
import math
import secrets
import threading
from typing import Any, Dict, Tuple

from tornado.web import create_signed_value, decode_signed_value

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.utc_time import US_PER_S
from gpr20_web.calls import ROLES, Person
from gpr20_web.faults import (
    AccountsFileError,
    NotLoggedInError,
    TooManyLoginsError,
    WrongLoginError,
)
from gpr20_web.low.accounts import Accounts

# So many wrong passwords of one account and address; then each next try waits so long [s].
FREE_FAILURES, PAUSE_S = 5, 60.0
MOST_KNOWN = 1000
# Signed too: nothing else that this key signs is a session.
SIGNED_NAME = "cookies.key"
HOURS_PER_DAY = 24.0


class Logins:
    """Begins and checks sessions; any thread may use it.

    Args:
        accounts: A session is over when its account is gone, or has another generation.
        key: Signs; another one ends every session.
        longest_hours: So long after the login a session is over [h].
    """

    def __init__(self, accounts: Accounts, key: bytes, longest_hours: float, clock: Clock) -> None:
        self._accounts, self._key, self._clock = accounts, key, clock
        self._longest_days = longest_hours / HOURS_PER_DAY
        self._lock = threading.Lock()
        # By account and address, that who guesses elsewhere keeps nobody out: how many failed, and
        # when the last one did; the one that failed longest ago is first.
        self._failures: Dict[Tuple[str, str], Tuple[int, float]] = {}

    def begin(self, name: str, password: str, address: str) -> Person:
        """Return a person with a new session.

        Args:
            name: What was given, also if there is no such account.
            password: Of the account.
            address: Where the request came from.

        Raises:
            TooManyLoginsError: It is too early; nothing was checked.
            WrongLoginError: There is no such account, or it has another password.
        """
        key = name.lower()[:40], address
        count, last_s = self._failures.get(key, (0, 0.0))
        wait_s = last_s + PAUSE_S - self._clock.now_s()
        if count >= FREE_FAILURES and wait_s > 0.0:
            raise TooManyLoginsError(
                Message("too many logins failed; wait {seconds} s", seconds=math.ceil(wait_s))
            )
        try:
            account = self._accounts.check(name, password)
        except WrongLoginError:
            with self._lock:
                count, _last_s = self._failures.pop(key, (0, 0.0))
                self._failures[key] = count + 1, self._clock.now_s()
                if len(self._failures) > MOST_KNOWN:
                    del self._failures[next(iter(self._failures))]
            raise
        with self._lock:
            self._failures.pop(key, None)
        content = {
            "name": account.name,
            "role": account.role.word,
            "generation": account.generation,
            # Of two browsers of one person only one is in control.
            "browser": secrets.token_urlsafe(),
        }
        signed = create_signed_value(
            self._key, SIGNED_NAME, json.dumps(content), clock=self._time_of_day_s
        )
        return Person(account.name, account.role, signed.decode(), address)

    def find(self, cookie: str, address: str) -> Person:
        """Return the person of a cookie, at an address; the cookie may be empty.

        Raises:
            NotLoggedInError: It is not signed here, or its session is over.
        """
        # What is no text has no signature.
        text = cookie.encode("utf-8", "replace")
        content = decode_signed_value(
            *(self._key, SIGNED_NAME, text), self._longest_days, clock=self._time_of_day_s
        )
        if content is None:
            raise NotLoggedInError(Message("nobody is logged in here, or no longer"))
        values: Dict[str, Any] = json.loads(content)
        person = Person(values["name"], ROLES[values["role"]], cookie, address)
        try:
            account = self._accounts.find(person.name)
        except AccountsFileError:
            return person  # whoever has logged in must still be able to stop the robot
        if account is None or account.generation != values["generation"]:
            raise NotLoggedInError(Message("the session is over"))
        return person

    def _time_of_day_s(self) -> float:
        return self._clock.time_of_day_us() / US_PER_S
