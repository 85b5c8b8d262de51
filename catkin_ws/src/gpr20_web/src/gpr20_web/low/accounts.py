"""Who may log in, and as what: a file that the command `users` changes. It is empty at first.

Each line is an account: name, role and the hash of its password by scrypt. A file whose hashes cost
more would have another first line.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
import unicodedata
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import SHORT_WAIT_S, locked, replace_file
from gpr20_survey.files.regular_files import read_regular
from gpr20_web.calls import ROLES, Role
from gpr20_web.faults import AccountError, AccountsFileError, WrongLoginError
from gpr20_web.low.web_folder import ensure_secret_folder

FILE_NAME, FIRST_LINE = "accounts.txt", "gpr20-accounts 1"
SHORTEST, LONGEST, LEAST_DIFFERENT = 12, 200, 5
PART_BYTES = 32
_NAME = re.compile("[a-z0-9][a-z0-9._-]{1,39}")
_LINE = re.compile(f"({_NAME.pattern}) ({'|'.join(ROLES)}) ([0-9a-f]{{{4 * PART_BYTES}}})")


class Cost(NamedTuple):
    """The parameters of scrypt."""

    n: int
    r: int
    p: int


# What it recommends for 32 MiB.
OWASP = Cost(1 << 15, 8, 3)


@dataclass(frozen=True)
class Account:
    """Somebody who may log in.

    Attributes:
        hash: Of the password: salt and key.
    """

    name: str
    role: Role
    hash: str

    @property
    def generation(self) -> str:
        """Another one after each change: the sessions of another generation are over."""
        return hashlib.sha256(f"{self.role.word} {self.hash}".encode()).hexdigest()


Named = Dict[str, Account]


def hash_of(password: str, cost: Cost = OWASP, salt: bytes = b"") -> str:
    """Return what is kept of a password; at the usual cost it takes a part of a second.

    Args:
        password: Any text.
        cost: Of the hash.
        salt: That of a known hash; empty: a new one.
    """
    salt = salt or secrets.token_bytes(PART_BYTES)
    key = hashlib.scrypt(
        # Keyboards write the same letter with an accent in two ways.
        unicodedata.normalize("NFC", password).encode("utf-8", "surrogatepass"),
        salt=salt,
        **cost._asdict(),
        # What it needs, and a little for OpenSSL itself.
        maxmem=128 * cost.r * (cost.n + cost.p + 2) + (1 << 20),
        dklen=PART_BYTES,
    )
    return (salt + key).hex()


def fits(password: str, known: str, cost: Cost = OWASP) -> bool:
    """Return whether a hash is that of a password."""
    salt = bytes.fromhex(known)[:PART_BYTES]
    return hmac.compare_digest(hash_of(password, cost, salt), known)


def check_password(password: str, name: str) -> None:
    """Refuse a new password that is easy to guess; where it is long no other rule is needed.

    Raises:
        AccountError: It is not allowed for the account of this name.
    """
    text = unicodedata.normalize("NFC", password)
    is_long = SHORTEST <= len(text) <= LONGEST and len(set(text)) >= LEAST_DIFFERENT
    if not (is_long and text.isprintable() and text.casefold() != name.casefold()):
        raise AccountError(
            Message(
                "a password must have {shortest} to {longest} letters, digits, signs and spaces, "
                "at least {least} different ones, and must not be the name",
                shortest=SHORTEST,
                longest=LONGEST,
                least=LEAST_DIFFERENT,
            )
        )


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
        cost: Of the hashes of passwords.
    """

    def __init__(self, folder: Path, cost: Cost = OWASP) -> None:
        self._folder, self._path = folder, folder / FILE_NAME
        self._cost = cost
        # What was read last, and the mark of its file: STOP waits for no disk.
        self._seen: Tuple[Tuple[int, ...], Named] = (), {}

    def all(self) -> List[Account]:
        """Return all, by name."""
        return sorted(self._read().values(), key=lambda one: one.name)

    def find(self, name: str) -> Optional[Account]:
        """Return the account of a name; None: there is none."""
        return self._read().get(name.lower())

    def check(self, name: str, password: str) -> Account:
        """Return the account of a name and its password.

        Raises:
            WrongLoginError: They do not fit.
        """
        account = self.find(name)
        if account is None:
            hash_of(password, self._cost)  # a name that is not there takes as long
        elif fits(password, account.hash, self._cost):
            return account
        raise WrongLoginError(Message("name or password is wrong"))

    def put(self, name: str, role: Role, password: str) -> None:
        """Make an account, or replace it: whoever is logged in with it is so no longer.

        Raises:
            AccountError: Name or password are not allowed.
        """
        name = checked_name(name)
        check_password(password, name)
        made = Account(name, role, hash_of(password, self._cost))
        self._change(lambda accounts: accounts.update({name: made}))

    def remove(self, name: str) -> None:
        """Remove an account.

        Raises:
            AccountError: There is no such account.
        """

        def change(accounts: Named) -> None:
            if accounts.pop(checked_name(name), None) is None:
                raise AccountError(Message("there is no account {name}", name=name))

        self._change(change)

    def _read(self) -> Named:
        """Return the accounts by their names, as the file has them now."""
        former, known = self._seen
        try:
            # Before the content: what changes between the two is read again the next time.
            found = self._path.stat()
            mark = found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino
            if mark != former:
                known = self._parse(read_regular(self._path))
                self._seen = mark, known
        except AccountsFileError:
            raise
        except OSError as error:
            if isinstance(error, FileNotFoundError) and not former:
                return {}
            # Removing all accounts leaves a file. Who is logged in can still stop.
            raise self._unusable(os_reason(error)) from error
        return known

    def _change(self, change: Callable[[Named], None]) -> None:
        """Change a copy of all accounts and write it; nobody else changes them meanwhile."""
        try:
            ensure_secret_folder(self._folder)
            with locked(self._folder, SHORT_WAIT_S):
                accounts = dict(self._read())
                change(accounts)
                lines = [f"{one.name} {one.role.word} {one.hash}" for one in accounts.values()]
                content = "\n".join([FIRST_LINE, *lines, ""])
                replace_file(self._path, content.encode())
        except SurveyRefusedError as error:
            raise self._unusable(Message("another program changes them")) from error
        except AccountsFileError:
            raise
        except OSError as error:
            raise self._unusable(os_reason(error)) from error

    def _parse(self, data: bytes) -> Named:
        # Lines end with a line feed alone, the last one too: half a file is damaged.
        first, *lines = data.decode("ascii", "replace").split("\n")
        found = [one.groups() for one in map(_LINE.fullmatch, lines[:-1]) if one is not None]
        accounts = {name: Account(name, ROLES[role], known) for name, role, known in found}
        if first != FIRST_LINE or lines[-1:] != [""] or len(accounts) != len(lines[:-1]):
            raise self._unusable(Message("the file is damaged, or of another version"))
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
