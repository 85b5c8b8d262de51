"""Who is logged in, also after a restart of the node."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import threading
from dataclasses import replace
from typing import Callable, List, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.calls import Person
from gpr20_web.errors import AccountsFileError, NotLoggedInError
from gpr20_web.low.account_file import Account
from gpr20_web.low.session_file import Session, SessionFile

TOKEN_BYTES = 32
MOST_OF_PERSON, MOST_SESSIONS = 10, 200
# The last use is kept to the full minute before it: the disk writes no more often [s].
KEPT_S = 60.0


class Sessions:
    """All sessions; any thread may use them.

    Args:
        find_account: Returns the account of a name as it is now.
        clock: Measures how long they last.
        idle_s: One that is not used for so long is over [s].
        longest_s: So long after the login it is over [s].
        file: Keeps them.
    """

    def __init__(
        self,
        find_account: Callable[[str], Optional[Account]],
        clock: Clock,
        idle_s: float,
        longest_s: float,
        file: SessionFile,
    ) -> None:
        self._find_account, self._now_s = find_account, clock.now_s
        self._idle_s, self._longest_s = idle_s, longest_s
        self._file, self._kept = file, file.read()
        self._lock, self._writing = threading.Lock(), threading.Lock()
        # By the hash of the token, which the cookie alone has; the oldest first.
        self._sessions = {one.hash: one for one in self._kept.sessions}

    def begin(self, account: Account) -> str:
        """Return the token of a new session, for the cookie; too many: the oldest one ends.

        Args:
            account: As it was when its password was checked.
        """
        token = self._signed(secrets.token_urlsafe(TOKEN_BYTES))
        with self._lock:
            now_s = self._now_s()
            self._remove([key for key, one in self._sessions.items() if self._is_late(one, now_s)])
            self._remove(self._keys_of(account.name)[: 1 - MOST_OF_PERSON])
            self._remove(list(self._sessions)[: 1 - MOST_SESSIONS])
            key, whose = _key(token), (account.name, account.role, account.generation)
            self._sessions[key] = Session(key, *whose, now_s, now_s)
        self.keep()
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
            account, key = self._check(token), _key(token)
            self._sessions[key] = replace(self._sessions[key], used_s=self._now_s())
        return Person(account.name, account.role, token, address)

    def end(self, token: str) -> None:
        """Log out."""
        with self._lock:
            self._sessions.pop(_key(token), None)
        self.keep()

    def end_all(self, name: str) -> None:
        """Log out in every browser."""
        with self._lock:
            self._remove(self._keys_of(name))
        self.keep()

    def keep(self) -> None:
        """Let a restart of the node find what is so now, also when each was used last."""
        # The disk delays nobody who uses the page.
        with self._writing:
            with self._lock:
                known = tuple(self._sessions.values())
            rounded = (replace(one, used_s=one.used_s // KEPT_S * KEPT_S) for one in known)
            now = replace(self._kept, sessions=tuple(rounded))
            if now != self._kept and self._file.write(now):
                self._kept = now

    def _signed(self, text: str) -> str:
        key, data = self._kept.key.encode(), text.encode("utf-8", "surrogatepass")
        return f"{text}.{hmac.new(key, data, 'sha256').hexdigest()}"

    def _check(self, token: str) -> Account:
        session = self._sessions.get(_key(token))
        if session is None or token != self._signed(token.partition(".")[0]):
            raise NotLoggedInError(Message("nobody is logged in here, or no longer"))
        try:
            account = self._find_account(session.name)
        except AccountsFileError:
            # Whoever has logged in must still be able to stop the robot.
            account = Account(session.name, session.role, "", "", session.generation)
        if (
            account is None
            or account.generation != session.generation
            or self._is_late(session, self._now_s())
        ):
            del self._sessions[_key(token)]
            raise NotLoggedInError(Message("the session is over"))
        return account

    def _is_late(self, session: Session, now_s: float) -> bool:
        idle_s, age_s = now_s - session.used_s, now_s - session.begun_s
        return idle_s >= self._idle_s or age_s >= self._longest_s

    def _keys_of(self, name: str) -> List[str]:
        return [key for key, one in self._sessions.items() if one.name == name]

    def _remove(self, keys: List[str]) -> None:
        for key in keys:
            del self._sessions[key]


def _key(token: str) -> str:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
