"""The file of those who are logged in, who stay so when the node is restarted."""

from __future__ import annotations

import json
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Callable, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_survey.files.durable_files import replace_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_web.low.secret_folder import ensure_secret_folder
from gpr20_web.roles import Role

KEY_BYTES = 32
# Another one after each start of the computer, which begins the clock of the sessions anew.
BOOT = Path("/proc/sys/kernel/random/boot_id")


@dataclass(frozen=True)
class Session:
    """A login: the hash of its token, whose it is, and when it was made and used last [s]."""

    hash: str
    name: str
    role: Role
    generation: int
    begun_s: float
    used_s: float


@dataclass(frozen=True)
class Logins:
    """The key that signs the tokens, and the sessions that are not over, the oldest first."""

    boot: str
    key: str
    sessions: Tuple[Session, ...] = ()


class SessionFile:
    """Reads and writes the file; `report` takes why that is not possible."""

    def __init__(self, folder: Path, report: Callable[[Message], None]) -> None:
        self._folder, self._path, self._report = folder, folder / "sessions.json", report

    def read(self) -> Logins:
        """Return what was written since the computer was started, else a new key."""
        found = new = Logins(BOOT.read_text(), secrets.token_hex(KEY_BYTES))
        try:
            if self._path.exists():
                kept = record_from(Logins, json.loads(read_regular(self._path)), "")
                if len(bytes.fromhex(kept.key)) != KEY_BYTES:
                    raise ValueError(f"key must have {KEY_BYTES} bytes, as hexadecimal digits")
                found = kept
        except (OSError, ValueError, RecursionError) as error:
            self._refused(error)
        return found if found.boot == new.boot else new

    def write(self, logins: Logins) -> bool:
        """Return whether they are durable now."""
        try:
            ensure_secret_folder(self._folder)
            replace_file(self._path, json.dumps(asdict(logins)).encode())
        except OSError as error:
            self._refused(error)
            return False
        return True

    def _refused(self, error: Exception) -> None:
        damage = Message("{file} is damaged, or old", file=self._path.name, details=str(error))
        reason = os_reason(error) if isinstance(error, OSError) else damage
        words = Message("logins and logouts cannot be kept: {reason}", reason=reason)
        self._report(words.with_fault(CONFIGURATION))
