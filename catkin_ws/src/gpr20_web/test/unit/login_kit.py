"""What the tests of accounts and sessions share."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List, Mapping, Tuple

from gpr20_common.low.clock import Clock
from gpr20_web.calls import Call
from gpr20_web.low.account_file import AccountFile
from gpr20_web.low.passwords import PasswordHash
from gpr20_web.low.session_file import Logins, SessionFile
from gpr20_web.mid.accounts import Accounts

# Hashes that cost nothing: the tests are about everything else.
CHEAP = PasswordHash(n=2, r=1, p=1)
PASSWORD, OTHER_PASSWORD = "correct horse battery", "staple of another kind"


class ManualClock(Clock):
    """Stands still until a test moves it."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        """Return the time [s]."""
        return self.time_s


class Noted:
    """Keeps what was reported to the audit."""

    def __init__(self) -> None:
        self.entries: List[Tuple[str, str, Mapping[str, Any]]] = []

    def __call__(
        self, call: Call, what: str, outcome: str = "", survey: str = "", **values: Any
    ) -> None:
        """Note an entry."""
        who = "" if call.person is None else call.person.name
        self.entries.append((who, what, {"outcome": outcome, **values}))


class NoFile(SessionFile):
    """Keeps sessions in memory, where a restart of the node finds them too."""

    def __init__(self) -> None:
        self.logins = Logins("boot", "key")

    def read(self) -> Logins:
        """Return what was written."""
        return self.logins

    def write(self, logins: Logins) -> bool:
        """Write it."""
        self.logins = logins
        return True


def make_accounts(folder: Path) -> Accounts:
    """Return the accounts of a folder, with hashes that cost nothing."""
    return Accounts(AccountFile(folder / "web"), Clock(), CHEAP)
