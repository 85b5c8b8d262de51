"""Who may log in, and as what. There is no account and no password by default."""

from __future__ import annotations

import dataclasses
import secrets
from typing import List, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.errors import AccountError, WrongLoginError
from gpr20_web.low import account_file
from gpr20_web.low.account_file import MAX_GENERATION, Account, AccountFile, checked_name
from gpr20_web.low.passwords import HASH_BYTES, PasswordHash, check_password
from gpr20_web.roles import Role

OWASP = PasswordHash()


class Accounts:
    """All accounts; any thread may use them.

    Every method raises AccountsFileError if the file of the accounts cannot be used.

    Args:
        file: Keeps them.
        clock: Gives the time of day.
        effort: Of the hashes of new passwords.
    """

    def __init__(self, file: AccountFile, clock: Clock, effort: PasswordHash = OWASP) -> None:
        self._file, self._clock, self._effort = file, clock, effort
        # As slow to check as the others; no password fits it.
        self._nobody = dataclasses.replace(effort, key=secrets.token_bytes(HASH_BYTES))

    def all(self) -> List[Account]:
        """Return all, by name."""
        return sorted(self._file.read().values(), key=lambda one: one.name)

    def find(self, name: str) -> Optional[Account]:
        """Return the account of a name; None: there is none."""
        return self._file.read().get(name.lower())

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
        made = Account(
            name,
            role,
            self._hash(password, name),
            iso_text(self._clock.time_of_day_us()),
            _new_generation(),
        )

        def change(accounts: account_file.Accounts) -> None:
            if name in accounts:
                raise AccountError(Message("there is an account {name} already", name=name))
            accounts[name] = made

        self._file.change(change)
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
            AccountError: There is no such account, or the change is not allowed.
        """
        name = checked_name(name)
        account = self.find(name)
        if account and password is not None and PasswordHash.parse(account.hash).fits(password):
            raise AccountError(
                Message("the new password is the present one; it must be another one")
            )
        hashed = None if password is None else self._hash(password, name)
        changed: List[Account] = []

        def change(accounts: account_file.Accounts) -> None:
            former = _known(accounts, name)
            accounts[name] = dataclasses.replace(
                former,
                role=former.role if role is None else role,
                hash=hashed or former.hash,
                generation=_new_generation(),
            )
            changed.append(accounts[name])

        self._file.change(change)
        return changed[0]

    def remove(self, name: str) -> None:
        """Remove an account.

        Raises:
            AccountError: There is no such account.
        """
        name = checked_name(name)

        def change(accounts: account_file.Accounts) -> None:
            del accounts[_known(accounts, name).name]

        self._file.change(change)

    def _hash(self, password: str, name: str) -> str:
        check_password(password, name)
        return str(self._effort.of(password))


def _known(accounts: account_file.Accounts, name: str) -> Account:
    if name not in accounts:
        raise AccountError(Message("there is no account {name}", name=name))
    return accounts[name]


def _new_generation() -> int:
    # By chance, not by counting: an account that is removed and made again has another one.
    return secrets.randbelow(MAX_GENERATION)
