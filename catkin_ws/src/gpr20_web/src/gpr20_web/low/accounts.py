"""Who may log in, and as what: a file that the command `users` changes. It is empty at first."""

from __future__ import annotations

import json
import re
import secrets
import threading
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import replace_file
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.calls import Role
from gpr20_web.errors import AccountError, AccountsFileError, WrongLoginError
from gpr20_web.low.passwords import HASH_BYTES, PasswordHash, check_password
from gpr20_web.low.secret_folder import ensure_secret_folder

FILE_NAME = "accounts.json"
FORMAT = "gpr20-accounts/2"
MAX_GENERATION = (1 << 53) - 1
_NAME = re.compile("[a-z0-9][a-z0-9._-]{1,39}")
Named = Dict[str, "Account"]
OWASP = PasswordHash()


@dataclass(frozen=True)
class Account:
    """Somebody who may log in.

    Attributes:
        hash: Of the password.
        created: When, ISO 8601.
        generation: Another one after each change of role or password, and by chance, not by
            counting: the sessions of another generation are over, also of a former account.
    """

    name: str
    role: Role
    hash: str
    created: str
    generation: int = bounded(0, MAX_GENERATION)


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


class Accounts:
    """All accounts; any thread may use them.

    Every method raises AccountsFileError if their file cannot be used.

    Args:
        folder: Of the page.
        effort: Of the hashes of new passwords.
    """

    def __init__(self, folder: Path, clock: Clock, effort: PasswordHash = OWASP) -> None:
        self._folder, self._path = folder, folder / FILE_NAME
        self._clock, self._effort = clock, effort
        # As slow to check as the others; no password fits it.
        self._nobody = replace(effort, key=secrets.token_bytes(HASH_BYTES))
        self._lock = threading.Lock()
        self._stamp: Optional[Tuple[int, ...]] = None
        self._known: Mapping[str, Account] = {}

    def all(self) -> List[Account]:
        """Return all, by name."""
        return sorted(self._read().values(), key=lambda one: one.name)

    def find(self, name: str) -> Optional[Account]:
        """Return the account of a name; None: there is none."""
        return self._read().get(name.lower())

    def check(self, name: str, password: str) -> Account:
        """Return the account of a name and its password.

        It takes as long for a name that is not there.

        Raises:
            WrongLoginError: They do not fit.
        """
        account = self.find(name)
        known = self._nobody if account is None else PasswordHash.parse(account.hash)
        if not known.fits(password) or account is None:
            raise WrongLoginError(Message("name or password is wrong"))
        return account

    def add(self, name: str, role: Role, password: str) -> Account:
        """Make an account.

        Raises:
            AccountError: The name is taken, or name or password are not allowed.
        """
        name = checked_name(name)
        created = iso_text(self._clock.time_of_day_us())
        made = Account(name, role, self._hash(password, name), created, _new_generation())

        def change(accounts: Named) -> None:
            if name in accounts:
                raise AccountError(Message("there is an account {name} already", name=name))
            accounts[name] = made

        self._change(change)
        return made

    def change(
        self, name: str, role: Optional[Role] = None, password: Optional[str] = None
    ) -> Account:
        """Change role or password; whoever is logged in with the account is so no longer.

        Args:
            name: Of the account.
            role: None: it stays.
            password: None: it stays.

        Raises:
            AccountError: There is no such account, or the password is not allowed.
        """
        name = checked_name(name)
        changes: Dict[str, Any] = {"generation": _new_generation()}
        if role is not None:
            changes["role"] = role
        if password is not None:
            changes["hash"] = self._hash(password, name)

        def change(accounts: Named) -> None:
            accounts[name] = replace(_existing(accounts, name), **changes)

        return self._change(change)[name]

    def remove(self, name: str) -> None:
        """Remove an account.

        Raises:
            AccountError: There is no such account.
        """
        name = checked_name(name)

        def change(accounts: Named) -> None:
            del accounts[_existing(accounts, name).name]

        self._change(change)

    def _hash(self, password: str, name: str) -> str:
        check_password(password, name)
        return str(self._effort.of(password))

    def _read(self) -> Mapping[str, Account]:
        """Return the accounts by their names, as the file has them now."""
        with self._lock:
            try:
                # Before the content: what changes between the two is read again the next time.
                stamp = self._stamp_now()
                if stamp is None and self._stamp is not None:
                    # Removing all accounts leaves a file. Who is logged in can still stop.
                    raise self._unusable(Message("the file is gone"))
                if stamp is not None and stamp != self._stamp:
                    self._known = self._parse(read_regular(self._path))
                    self._stamp = stamp
            except AccountsFileError:
                raise
            except OSError as error:
                raise self._unusable(os_reason(error)) from error
            return self._known

    def _change(self, change: Callable[[Named], None]) -> Named:
        """Change a copy of all accounts and write it; nobody else changes them meanwhile."""
        try:
            ensure_secret_folder(self._folder)
            with locked(self._folder, SHORT_WAIT_S):
                accounts = dict(self._read())
                change(accounts)
                stored = [{**asdict(one), "role": one.role.word} for one in accounts.values()]
                content = {"format": FORMAT, "accounts": stored}
                replace_file(self._path, json.dumps(content, indent=1).encode() + b"\n")
        except SurveyRefusedError as error:
            raise self._unusable(Message("another program changes them")) from error
        except AccountsFileError:
            raise
        except OSError as error:
            raise self._unusable(os_reason(error)) from error
        return accounts

    def _stamp_now(self) -> Optional[Tuple[int, ...]]:
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return None
        return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino

    def _parse(self, data: bytes) -> Mapping[str, Account]:
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


def _existing(accounts: Mapping[str, Account], name: str) -> Account:
    if name not in accounts:
        raise AccountError(Message("there is no account {name}", name=name))
    return accounts[name]


def _account(values: Mapping[str, Any]) -> Account:
    account = record_from(Account, {**values, "role": Role.of(values["role"])}, "")
    if account.name != checked_name(account.name):
        raise ValueError(f"the name {account.name!r} has large letters")
    PasswordHash.parse(account.hash)
    return account


def _new_generation() -> int:
    return secrets.randbelow(MAX_GENERATION)
