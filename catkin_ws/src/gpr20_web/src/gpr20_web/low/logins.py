"""Who is logged in: what tornado has signed in the cookie of each browser; nothing is kept here."""

from __future__ import annotations

import json
import secrets
from typing import Any, Dict

from tornado.web import create_signed_value, decode_signed_value

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.utc_time import US_PER_S
from gpr20_web.calls import ROLES, Person
from gpr20_web.errors import AccountsFileError, NotLoggedInError
from gpr20_web.low.accounts import Account, Accounts

# Signed too: nothing else that this key signs is a session.
SIGNED_NAME = "cookies.key"
HOURS_PER_DAY = 24.0
VERSION = 2


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

    def begin(self, account: Account) -> str:
        """Return the cookie of a new session for an account whose password was checked."""
        content = {
            "name": account.name,
            "role": account.role.word,
            "generation": account.generation,
            # Of two browsers of one person only one is in control.
            "browser": secrets.token_urlsafe(),
        }
        signed = create_signed_value(
            self._key, SIGNED_NAME, json.dumps(content), version=VERSION, clock=self._now_s
        )
        return signed.decode()

    def find(self, cookie: str, address: str) -> Person:
        """Return the person of a cookie, at an address; the cookie may be empty.

        Raises:
            NotLoggedInError: It is not signed here, or its session is over.
        """
        # What is no text has no signature.
        text = cookie.encode("utf-8", "replace")
        content = decode_signed_value(
            *(self._key, SIGNED_NAME, text), self._longest_days, clock=self._now_s
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

    def _now_s(self) -> float:
        return self._clock.time_of_day_us() / US_PER_S
