"""users: the accounts of the page, from the command line of its computer; ROS need not run."""

from __future__ import annotations

import argparse
import getpass
import os
import sys
from pathlib import Path
from typing import Callable

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.clock import Clock
from gpr20_common.low.data_folder import configured, robot_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import say
from gpr20_web.errors import AccountError
from gpr20_web.low.account_file import AccountFile, checked_name, role_of
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.web_parameters import WebParameters
from gpr20_web.roles import Role

FILE = "web.yaml"


def main() -> int:
    """Do what the command line asks; return the exit status."""
    given = _parser().parse_args()
    try:
        accounts = Accounts(AccountFile(_folder(given)), Clock())
        given.act(accounts, given)
        return 0
    except Gpr20Error as error:
        remedy = [] if error.message.remedy is None else [f"-> {error.message.remedy}"]
        say(f"users: {error}", *remedy, file=sys.stderr)
    except OSError as error:
        say(f"users: {error.filename}: {os_reason(error)}", file=sys.stderr)
    except KeyboardInterrupt:
        say("users: nothing was changed", file=sys.stderr)
    return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="users", description="Manage the accounts of the page for browsers."
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")
    actions.required = True
    roles = [one.word for one in Role if one is not Role.NOBODY]

    def add(name: str, act: Callable[..., None], text: str) -> argparse.ArgumentParser:
        one = actions.add_parser(name, help=text, description=text)
        one.set_defaults(act=act)
        one.add_argument("--folder", help="of the page; default: that of web.yaml")
        if name != "list":
            one.add_argument("name", metavar="NAME")
        return one

    add("list", _list, "show the accounts")
    new = add("add", _add, "make an account")
    new.add_argument("--role", choices=roles, required=True)
    password = add("password", _password, "give an account another password")
    add("role", _role, "give an account another role").add_argument("role", choices=roles)
    add("remove", _remove, "remove an account")
    for one in (new, password):
        one.add_argument("--stdin", action="store_true", help="read the password as one line")
    return parser


def _folder(given: argparse.Namespace) -> Path:
    """Return the folder of the page that the robot's configuration describes, or the given one."""
    if given.folder:
        return Path(given.folder).expanduser().absolute()
    file = robot_folder(os.environ) / FILE
    return record_from(WebParameters, configured(file), str(file)).path


def _list(accounts: Accounts, given: argparse.Namespace) -> None:
    found = accounts.all()
    if found:
        say(*(f"{one.name:40} {one.role.word:8} {one.created[:10]}" for one in found))
    else:
        say(f"users: there are no accounts in {_folder(given)}", file=sys.stderr)


def _add(accounts: Accounts, given: argparse.Namespace) -> None:
    if accounts.find(checked_name(given.name)) is not None:
        raise AccountError(Message("there is an account {name} already", name=given.name))
    made = accounts.add(given.name, role_of(given.role), _asked_password(given.stdin))
    say(f"{made.name}: account made, {made.role.word}")


def _password(accounts: Accounts, given: argparse.Namespace) -> None:
    if accounts.find(given.name) is None:
        raise AccountError(Message("there is no account {name}", name=given.name))
    changed = accounts.change(given.name, password=_asked_password(given.stdin))
    say(f"{changed.name}: password changed; whoever was logged in is so no longer")


def _role(accounts: Accounts, given: argparse.Namespace) -> None:
    changed = accounts.change(given.name, role_of(given.role))
    say(f"{changed.name}: {changed.role.word}; whoever was logged in is so no longer")


def _remove(accounts: Accounts, given: argparse.Namespace) -> None:
    accounts.remove(given.name)
    say(f"{given.name}: removed")


def _asked_password(from_stdin: bool) -> str:
    """Return a new password; a person types it twice, because nobody sees it."""
    if from_stdin:
        # Bytes that are no text make no password, which is refused like any other.
        line = sys.stdin.buffer.readline()
        return line.decode("utf-8", "surrogateescape").rstrip("\r\n")
    try:
        password = getpass.getpass("New password: ")
        again = getpass.getpass("Again: ")
    except EOFError as error:
        raise AccountError(Message("no password was given")) from error
    if password != again:
        raise AccountError(Message("the two passwords are different"))
    return password
