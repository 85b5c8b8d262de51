"""Logging in and out."""

from __future__ import annotations

import dataclasses
from typing import Any, Mapping

from gpr20_common.message import Message
from gpr20_web.calls import Audited, Call, Cookie, Route, text_of
from gpr20_web.errors import WrongLoginError
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.login_limits import LoginLimits
from gpr20_web.mid.sessions import Sessions
from gpr20_web.mid.web_page import WebPage
from gpr20_web.roles import Role


class LoginPage(WebPage):
    """The form in front of all other pages.

    Args:
        accounts: Who may log in.
        sessions: Who is logged in.
        limits: How often somebody may guess.
        audit: Notes who did what.
    """

    words: Mapping[str, Message] = {
        "name": Message("Name"),
        "password": Message("Password"),
        "log_in": Message("LOG IN"),
        "log_out": Message("LOG OUT"),
        "log_out_everywhere": Message("LOG OUT EVERYWHERE"),
    }

    def __init__(
        self,
        accounts: Accounts,
        sessions: Sessions,
        limits: LoginLimits,
        audit: Audited,
    ) -> None:
        self._accounts, self._sessions, self._limits = accounts, sessions, limits
        self._audit = audit
        self.routes = (
            Route("POST", "/api/login", Role.NOBODY, self._log_in, blocking=True),
            Route("POST", "/api/logout", Role.VIEW, self._log_out, True),
            Route("POST", "/api/logout_everywhere", Role.VIEW, self._log_out_everywhere, True),
            Route("GET", "/api/me", Role.VIEW, self._me),
        )

    def _log_in(self, call: Call) -> Cookie:
        name = text_of(call, "name")
        try:
            with self._limits.attempt(name, call.address):
                account = self._accounts.check(name, text_of(call, "password"))
        except WrongLoginError as error:
            # An unknown name may be a password, typed in the wrong field.
            known = self._accounts.find(name) is not None
            self._audit(call, "login", error.message.fault_code, name=name if known else "?")
            raise
        # Another session than the browser had, whichever that was.
        token = self._sessions.begin(account)
        own = dataclasses.replace(call, person=self._sessions.find(token, call.address))
        self._audit(own, "login", "done")
        return Cookie(token, self._me(own))

    def _log_out(self, call: Call) -> Cookie:
        self._sessions.end(call.who.session)
        self._audit(call, "logout", "done")
        return Cookie("")

    def _log_out_everywhere(self, call: Call) -> Cookie:
        self._sessions.end_all(call.who.name)
        self._audit(call, "logout_everywhere", "done")
        return Cookie("")

    def _me(self, call: Call) -> Mapping[str, Any]:
        person = call.who
        return {
            "name": person.name,
            "role": int(person.role),
            "mark": person.mark,
        }
