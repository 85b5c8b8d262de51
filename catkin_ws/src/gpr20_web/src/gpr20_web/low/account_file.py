"""The file of the accounts, which the page and the command `users` change."""

from __future__ import annotations

import dataclasses
import json
import re
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import replace_file
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.files.regular_file import read_regular
from gpr20_web.errors import AccountError, AccountsFileError
from gpr20_web.low.passwords import PasswordHash
from gpr20_web.low.secret_folder import ensure_secret_folder
from gpr20_web.roles import Role

FILE_NAME = "accounts.json"
FORMAT = "gpr20-accounts/1"
MAX_GENERATION = (1 << 53) - 1
_NAME = re.compile("[a-z0-9][a-z0-9._-]{1,39}")


@dataclass(frozen=True)
class Account:
    """Somebody who may log in.

    Attributes:
        hash: Of the password.
        created: When, ISO 8601.
        generation: Another one after each change of role or password, and never one that was
            there before: the sessions of another generation are over.
    """

    name: str
    role: Role
    hash: str
    created: str
    generation: int = bounded(0, MAX_GENERATION)


Accounts = Dict[str, Account]


def checked_name(name: str) -> str:
    """Return a name in small letters: a telephone's keyboard begins with a large one.

    Raises:
        AccountError: It is not allowed.
    """
    small = name.lower()
    if not _NAME.fullmatch(small):
        raise AccountError(
            Message(
                "the name is {name}; it must have 2 to 40 letters a-z, digits, full stops, "
                "hyphens or underscores, and begin with a letter or digit",
                name=repr(name[:80]),
            )
        )
    return small


def role_of(word: object) -> Role:
    """Return the role of a word.

    Raises:
        AccountError: An account cannot have it.
    """
    known = {one.word: one for one in Role if one is not Role.NOBODY}
    if not isinstance(word, str) or word not in known:
        allowed = ", ".join(known)
        raise AccountError(
            Message(
                "the role is {role}; it must be one of {roles}",
                role=repr(word)[:80],
                roles=allowed,
            )
        )
    return known[word]


class AccountFile:
    """Reads and changes the file; any thread may use it.

    Args:
        folder: Where it is.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._path = folder, folder / FILE_NAME
        self._lock = threading.Lock()
        self._stamp: Optional[Tuple[int, ...]] = None
        self._accounts: Accounts = {}

    def read(self) -> Mapping[str, Account]:
        """Return the accounts by their names, as they are now; none without a file.

        Raises:
            AccountsFileError: The file is damaged, cannot be read, or was there before.
        """
        with self._lock:
            try:
                # Before the content: what changes between the two is read again the next time.
                stamp = self._stamp_now()
                if stamp is None and self._stamp is not None:
                    # Removing all accounts leaves a file. Who is logged in can still stop.
                    raise self._unusable(Message("the file is gone"))
                if stamp is None:
                    return {}
                if stamp != self._stamp:
                    self._accounts = self._parse(read_regular(self._path))
                    self._stamp = stamp
            except AccountsFileError:
                raise
            except OSError as error:
                raise self._unusable(os_reason(error)) from error
            return self._accounts

    def change(self, change: Callable[[Accounts], None]) -> None:
        """Change the accounts in one step; nobody else changes them meanwhile.

        Args:
            change: Takes a copy of all and changes that; what it raises ends it without a change.

        Raises:
            AccountsFileError: The file is damaged, cannot be written, or is held by another.
        """
        try:
            ensure_secret_folder(self._folder)
            with locked(self._folder, SHORT_WAIT_S):
                accounts = dict(self.read())
                change(accounts)
                replace_file(self._path, _written(accounts))
        except SurveyRefusedError as error:
            raise self._unusable(Message("another program changes them")) from error
        except AccountsFileError:
            raise
        except OSError as error:
            raise self._unusable(os_reason(error)) from error

    def _stamp_now(self) -> Optional[Tuple[int, ...]]:
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return None
        return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino

    def _parse(self, data: bytes) -> Accounts:
        try:
            content = json.loads(data)
            if content["format"] != FORMAT:
                raise ValueError(f"format is {content['format']!r}; it must be {FORMAT!r}")
            found = [_account(one) for one in content["accounts"]]
            accounts = {one.name: one for one in found}
            if len(accounts) != len(found):
                raise ValueError("two accounts have one name")
        except (ValueError, LookupError, TypeError, RecursionError) as error:
            # Of a value that is missing Python says the name alone.
            words = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            reason = Message("the file is damaged, or of another version", details=words[:200])
            raise self._unusable(reason) from error
        return accounts

    def _unusable(self, reason: Message) -> AccountsFileError:
        return AccountsFileError(
            Message(
                "the file of the accounts cannot be used: {reason}",
                reason=reason,
                # For the log; no browser learns it.
                details=printable(self._path),
            )
        )


def _account(values: Mapping[str, Any]) -> Account:
    account = record_from(Account, {**values, "role": role_of(values["role"])}, "")
    if account.name != checked_name(account.name):
        raise ValueError(f"the name {account.name!r} has large letters")
    PasswordHash.parse(account.hash)
    return account


def _written(accounts: Accounts) -> bytes:
    stored = [{**dataclasses.asdict(one), "role": one.role.word} for one in accounts.values()]
    return json.dumps({"format": FORMAT, "accounts": stored}, indent=1).encode() + b"\n"
