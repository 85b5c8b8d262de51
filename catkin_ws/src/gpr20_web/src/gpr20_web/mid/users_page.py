"""USERS: the accounts, for administrators, and everybody's own password."""

from __future__ import annotations

from typing import Any, Mapping

from gpr20_common.message import Message
from gpr20_web.calls import Audited, Call, Route, text_of
from gpr20_web.errors import BadRequestError
from gpr20_web.low.account_file import role_of
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.web_page import WebPage
from gpr20_web.roles import Role

_USER = "/api/users/(?P<name>[^/]{1,80})"


class UsersPage(WebPage):
    """The page USERS.

    Args:
        accounts: Who may log in.
        audit: Notes who did what.
    """

    words: Mapping[str, Message] = {
        "title": Message("Users"),
        "name": Message("Name"),
        "role": Message("Role"),
        "view": Message("watches, pauses and stops"),
        "operate": Message("starts, resumes"),
        "admin": Message("manages the users"),
        "created": Message("Since"),
        "you": Message("you"),
        "add": Message("ADD A USER"),
        "change": Message("CHANGE"),
        "remove": Message("REMOVE"),
        "remove_user": Message("Remove the user {name}?", name="{name}"),
        "change_user": Message("Change the user {name}?", name="{name}"),
        "over": Message("Everybody who is logged in with this account must log in again."),
        "new_password": Message("New password, at least 12 characters"),
        "same_password": Message("New password, or empty: it stays"),
        "old_password": Message("Present password"),
        "again": Message("New password again"),
        "different": Message("The new passwords are different."),
        "own": Message("Your password"),
        "change_own": Message("CHANGE THE PASSWORD"),
        "changed": Message("The password was changed. Other browsers must log in again."),
    }

    def __init__(self, accounts: Accounts, audit: Audited) -> None:
        self._accounts, self._audit = accounts, audit
        self.routes = (
            Route("GET", "/api/users", Role.ADMIN, self._list, blocking=True),
            Route("POST", "/api/users", Role.ADMIN, self._add, blocking=True),
            Route("POST", _USER, Role.ADMIN, self._change, blocking=True),
            Route("DELETE", _USER, Role.ADMIN, self._remove, blocking=True),
        )

    def _list(self, _call: Call) -> Mapping[str, Any]:
        return {
            "users": [
                {"name": one.name, "role": one.role.word, "created": one.created}
                for one in self._accounts.all()
            ]
        }

    def _add(self, call: Call) -> Mapping[str, Any]:
        role = role_of(call.values.get("role"))
        made = self._accounts.add(text_of(call, "name"), role, text_of(call, "password"))
        self._audit(call, "add_user", "done", name=made.name, role=role.word)
        return self._list(call)

    def _change(self, call: Call) -> Mapping[str, Any]:
        given = call.values
        role = role_of(given["role"]) if "role" in given else None
        password = text_of(call, "password") if "password" in given else None
        if role is None and password is None:
            raise BadRequestError(Message("neither role nor password is given"))
        changed = self._accounts.change(call.parts["name"], role, password)
        self._audit(
            call,
            "change_user",
            "done",
            name=changed.name,
            role=changed.role.word,
            password=password is not None,
        )
        return self._list(call)

    def _remove(self, call: Call) -> Mapping[str, Any]:
        self._accounts.remove(call.parts["name"])
        self._audit(call, "remove_user", "done", name=call.parts["name"].lower())
        return self._list(call)
