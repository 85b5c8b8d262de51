"""Who is logged in: what tornado has signed in the cookie of each browser; nothing is kept here."""

from __future__ import annotations

import json
import secrets
from pathlib import Path
from typing import Any, Dict

from tornado.web import create_signed_value, decode_signed_value

from gpr20_common.errors import os_reason
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.trace.utc_time import US_PER_S
from gpr20_web.calls import Person, Role
from gpr20_web.errors import AccountsFileError, FolderError, NotLoggedInError
from gpr20_web.low.accounts import Account, Accounts
from gpr20_web.low.secret_folder import ensure_secret_folder

KEY_NAME, KEY_BYTES = "cookies.key", 32
S_PER_DAY = 86400.0
VERSION = 2


class Logins:
    """Begins and checks sessions; any thread may use it.

    Args:
        accounts: A session is over when its account is gone, or has another generation.
        key: Signs; another one ends every session.
        longest_s: So long after the login a session is over [s].
    """

    def __init__(self, accounts: Accounts, key: bytes, longest_s: float, clock: Clock) -> None:
        self._accounts, self._key, self._clock = accounts, key, clock
        self._longest_days = longest_s / S_PER_DAY

    def begin(self, account: Account) -> str:
        """Return what the cookie of a new session has.

        Args:
            account: As it was when its password was checked.
        """
        content = {
            "name": account.name,
            "role": account.role.word,
            "generation": account.generation,
            # Of two browsers of one person only one is in control.
            "browser": secrets.token_urlsafe(),
        }
        signed = create_signed_value(
            self._key, KEY_NAME, json.dumps(content), version=VERSION, clock=self._now_s
        )
        return signed.decode()

    def find(self, cookie: str, address: str) -> Person:
        """Return the person of a cookie.

        Args:
            cookie: Empty: there was none.
            address: Where the request came from.

        Raises:
            NotLoggedInError: It is not signed here, or its session is over.
        """
        # What is no text has no signature.
        text = cookie.encode("utf-8", "replace")
        content = decode_signed_value(
            *(self._key, KEY_NAME, text), self._longest_days, clock=self._now_s
        )
        if content is None:
            raise NotLoggedInError(Message("nobody is logged in here, or no longer"))
        values: Dict[str, Any] = json.loads(content)
        name, role = values["name"], Role.of(values["role"])
        try:
            account = self._accounts.find(name)
            if account is None or account.generation != values["generation"]:
                raise NotLoggedInError(Message("the session is over"))
        except AccountsFileError:
            # Whoever has logged in must still be able to stop the robot.
            return Person(name, role, cookie, address)
        return Person(name, account.role, cookie, address)

    def _now_s(self) -> float:
        return self._clock.time_of_day_us() / US_PER_S


def ensure_key(folder: Path) -> bytes:
    """Return the key of the folder of the page; make it if there is none.

    Raises:
        FolderError: The folder or the file cannot be used.
    """
    path = folder / KEY_NAME
    ensure_secret_folder(folder)
    try:
        if not path.exists():
            write_new_file(path, secrets.token_bytes(KEY_BYTES))
        key = read_regular(path)
    except OSError as error:
        reason = os_reason(error)
        raise FolderError(
            Message("the key of the logins cannot be kept: {reason}", reason=reason)
        ) from error
    if len(key) != KEY_BYTES:
        raise FolderError(
            Message(
                "{file} has {count} bytes; it must have {most}: remove it, and everybody logs in "
                "again",
                file=printable(path),
                count=len(key),
                most=KEY_BYTES,
            )
        )
    return key
