"""What is around every page: the login, all words, the colours of the window, what is live."""

from __future__ import annotations

from typing import Any, Dict, Mapping, Sequence

from gpr20_common.catalogue import Language, languages, read_catalogue
from gpr20_common.message import DECIMAL_POINT, Message
from gpr20_operator.palette import LEVEL_COLOURS, Mark, TextColours, Theme
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.calls import (
    Body,
    Call,
    Cookie,
    Document,
    Person,
    Role,
    Route,
    Stream,
    WebPage,
    text_of,
)
from gpr20_web.low.event_streams import json_text
from gpr20_web.low.logins import Logins

# What changes with each trace: nobody reads it faster, and each change costs every browser work.
# Another level of the band is in `robot`, and is sent at once.
SELDOM = frozenset({"band", "job", "ground"})

WORDS: Mapping[str, Message] = {
    "shell.point": DECIMAL_POINT,
    "shell.pages": Message("Pages"),
    "more.title": Message("More"),
    "login.name": Message("Name"),
    "login.password": Message("Password"),
    "login.log_in": Message("Log in"),
    "login.log_out": Message("Log out"),
    "shell.language": Message("Language"),
    "shell.sun": Message("Sunlight"),
    "shell.night": Message("Night"),
    "shell.close": Message("CLOSE"),
    "shell.connecting": Message("Connecting to the robot's computer."),
    "shell.stale": Message(
        "NO CONNECTION: what you see is {seconds} s old. The robot may have moved since.",
        seconds="{seconds}",
    ),
    # An answer of the main control says nothing of the motors.
    "shell.stop_done": Message(
        "{command}: the request was accepted. The robot rests only when its state says so",
        command="{command}",
    ),
    "shell.stop_refused": Message(
        "{command}: no survey was stopped. The axes were asked to stop all the same",
        command="{command}",
    ),
    "shell.over": Message("You are no longer logged in: log in again."),
    "shell.no_answer": Message("The robot's computer does not answer. Check the network."),
}


class Shell:
    """Joins the pages.

    Args:
        pages: Each with the name under which its script asks for its words.
        logins: Begins sessions.
    """

    def __init__(self, pages: Mapping[str, WebPage], logins: Logins) -> None:
        self.pages, self._logins = pages, logins
        # By language, until the next refresh.
        self._documents: Dict[str, Document] = {}

    def on_event(self, event: object) -> None:
        """Pass an event on."""
        for page in self.pages.values():
            page.on_event(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Pass on what is known now."""
        self._documents.clear()
        for page in self.pages.values():
            page.refresh(snapshot)

    def all_routes(self) -> Sequence[Route]:
        """Return the whole table."""
        return [
            Route("GET", "/api/words", Role.NOBODY, self._words),
            Route("GET", "/api/colours.css", Role.NOBODY, lambda _call: _colours()),
            Route("POST", "/api/login", Role.NOBODY, self._log_in, blocking=True),
            Route("POST", "/api/logout", Role.WATCH, lambda _call: Cookie("")),
            Route("GET", "/api/me", Role.WATCH, lambda call: _me(call.who)),
            Route("GET", "/api/live", Role.WATCH, self._live),
            *(one for page in self.pages.values() for one in page.routes),
        ]

    def document(self, language: Language) -> Document:
        """Return what a browser sees now; it is made once for each language."""
        code = language.value
        if code not in self._documents:
            text = read_catalogue(language).text
            shown = [one for page in self.pages.values() for one in page.live(text).items()]
            urgent, seldom = (
                "".join(
                    f'"{name}":{json_text(one)},'
                    for name, one in shown
                    if (name in SELDOM) is later
                )
                for later in (False, True)
            )
            self._documents[code] = Document(urgent, seldom)
        return self._documents[code]

    def _words(self, call: Call) -> Mapping[str, Any]:
        words = dict(WORDS)
        for name, page in self.pages.items():
            words.update({f"{name}.{key}": one for key, one in page.words.items()})
        return {
            "me": None if call.person is None else _me(call.person),
            "language": call.language.value,
            "languages": [[one.value, one.own_name] for one in languages()],
            # With their fields, which the script fills in.
            "words": {name: call.text(one) for name, one in words.items()},
        }

    def _log_in(self, call: Call) -> Cookie:
        name, password = text_of(call, "name"), text_of(call, "password")
        person = self._logins.begin(name, password, call.address)
        return Cookie(person.session, _me(person))

    def _live(self, call: Call) -> Stream:
        return Stream(lambda: self.document(call.language))


def _me(person: Person) -> Mapping[str, Any]:
    return {"name": person.name, "role": int(person.role), "mark": person.mark}


def _colours() -> Body:
    """Return the colours of the window as variables of a style sheet."""
    sheets = []
    for theme in Theme:
        lines = [f"--mark-{_name(one.name)}:{one.of(theme)};" for one in Mark]
        for name, pair in [
            *((one.name, one.of(theme)) for one in TextColours),
            *((f"level_{level.value}", one.of(theme)) for level, one in LEVEL_COLOURS.items()),
        ]:
            lines += [f"--{_name(name)}-ink:{pair.ink};", f"--{_name(name)}-ground:{pair.ground};"]
        sheets.append(f':root[data-theme="{theme.value}"]{{{"".join(lines)}}}')
    return Body("\n".join(sheets).encode(), "text/css; charset=UTF-8")


def _name(name: str) -> str:
    return name.lower().replace("_", "-")
