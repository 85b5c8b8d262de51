"""users: the accounts of the page, from the command line of its computer; ROS need not run."""

from __future__ import annotations

import argparse
import getpass
import os
import sys
from pathlib import Path

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.yaml_file import configured, robot_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import say
from gpr20_web.calls import ROLES
from gpr20_web.faults import AccountError
from gpr20_web.low.accounts import Accounts, checked_name
from gpr20_web.mid.web_parameters import WebParameters

FILE = "web.yaml"


def main() -> int:
    """Do what the command line asks; return the exit status."""
    given = _parser().parse_args()
    try:
        given.act(Accounts(_folder(given)), given)
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
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for act, text in (
        (_list, "show the accounts"),
        (_add, "make an account, or give it another role and password"),
        (_remove, "remove an account"),
    ):
        one = actions.add_parser(act.__name__.strip("_"), help=text, description=text)
        one.set_defaults(act=act)
        one.add_argument("--folder", help="of the page; default: that of web.yaml")
        if act is not _list:
            one.add_argument("name", metavar="NAME")
        if act is _add:
            one.add_argument("--role", choices=[*ROLES], required=True)
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
        say(*(f"{one.name:40} {one.role.word}" for one in found))
    else:
        say(f"users: there are no accounts in {_folder(given)}", file=sys.stderr)


def _add(accounts: Accounts, given: argparse.Namespace) -> None:
    name = checked_name(given.name)
    done = "account made" if accounts.find(name) is None else "account changed, and logged out"
    accounts.put(name, ROLES[given.role], _asked_password(given.stdin))
    say(f"{name}: {done}, {given.role}")


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
