"""Who is logged in. Sessions are in memory alone: a restart of the page ends them."""

from __future__ import annotations

import hashlib
import secrets
import threading
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.calls import Person
from gpr20_web.errors import AccountsFileError, NotLoggedInError
from gpr20_web.low.account_file import Account

TOKEN_BYTES = 32
MOST_OF_PERSON, MOST_SESSIONS = 10, 200


@dataclass
class _Session:
    account: Account
    begun_s: float
    used_s: float


class Sessions:
    """All sessions; any thread may use them.

    Args:
        find_account: Returns the account of a name as it is now.
        clock: Measures how long they last.
        idle_s: One that is not used for so long is over [s].
        longest_s: So long after the login it is over [s].
    """

    def __init__(
        self,
        find_account: Callable[[str], Optional[Account]],
        clock: Clock,
        idle_s: float,
        longest_s: float,
    ) -> None:
        self._find_account, self._now_s = find_account, clock.now_s
        self._idle_s, self._longest_s = idle_s, longest_s
        self._lock = threading.Lock()
        # By the hash of the token, which the cookie alone has; the oldest first.
        self._sessions: Dict[bytes, _Session] = {}

    def begin(self, account: Account) -> str:
        """Return the token of a new session, for the cookie; too many: the oldest one ends.

        Args:
            account: As it was when its password was checked.
        """
        token = secrets.token_urlsafe(TOKEN_BYTES)
        with self._lock:
            now_s = self._now_s()
            self._remove([key for key, one in self._sessions.items() if self._is_late(one, now_s)])
            self._remove(self._keys_of(account.name)[: 1 - MOST_OF_PERSON])
            self._remove(list(self._sessions)[: 1 - MOST_SESSIONS])
            self._sessions[_key(token)] = _Session(account, now_s, now_s)
        return token

    def find(self, token: str, address: str) -> Person:
        """Return the person of a token, who uses the page.

        Args:
            token: Of the cookie; empty: there was none.
            address: Where the request came from.

        Raises:
            NotLoggedInError: There is no such session, or no longer.
        """
        with self._lock:
            account = self._check(token)
            self._sessions[_key(token)].used_s = self._now_s()
        return Person(account.name, account.role, token, address)

    def end(self, token: str) -> None:
        """Log out."""
        with self._lock:
            self._sessions.pop(_key(token), None)

    def end_all(self, name: str) -> None:
        """Log out in every browser."""
        with self._lock:
            self._remove(self._keys_of(name))

    def _check(self, token: str) -> Account:
        session = self._sessions.get(_key(token))
        if session is None:
            raise NotLoggedInError(Message("nobody is logged in here, or no longer"))
        try:
            account = self._find_account(session.account.name)
        except AccountsFileError:
            # Whoever has logged in must still be able to stop the robot.
            account = session.account
        if (
            account is None
            or account.generation != session.account.generation
            or self._is_late(session, self._now_s())
        ):
            del self._sessions[_key(token)]
            raise NotLoggedInError(Message("the session is over"))
        return account

    def _is_late(self, session: _Session, now_s: float) -> bool:
        idle_s, age_s = now_s - session.used_s, now_s - session.begun_s
        return idle_s >= self._idle_s or age_s >= self._longest_s

    def _keys_of(self, name: str) -> List[bytes]:
        return [key for key, one in self._sessions.items() if one.account.name == name]

    def _remove(self, keys: List[bytes]) -> None:
        for key in keys:
            del self._sessions[key]


def _key(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()
