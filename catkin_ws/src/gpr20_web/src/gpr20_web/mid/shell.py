"""What is around every page: its document with words and colours, the login, what is live."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Match, Sequence

from gpr20_common.catalogue import Language, languages, read_catalogue
from gpr20_common.message import DECIMAL_POINT, Message
from gpr20_operator.palette import LEVEL_COLOURS, Mark, TextColours, Theme
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.calls import (
    Call,
    Cookie,
    Document,
    File,
    Person,
    Role,
    Route,
    WebPage,
    text_of,
)
from gpr20_web.low.event_streams import json_text
from gpr20_web.low.logins import Logins

# What changes with each trace: nobody reads it faster, and each change costs every browser work.
# Another level of the band is in `robot`, and is sent at once.
SELDOM = frozenset({"band", "job", "ground"})
# What is put into index.html in place of its address.
PARTS = re.compile(r'<(?:link rel="stylesheet" href|(script) src)="(.+?)">(?:</script>)?')
WORDS_BEGIN = '<script type="application/json" id="words">'

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

    def show_state(self, snapshot: Snapshot) -> None:
        """Pass on what is known now."""
        self._documents.clear()
        for page in self.pages.values():
            page.show_state(snapshot)

    def all_routes(self) -> Sequence[Route]:
        """Return the whole table."""
        return [
            Route("POST", "/api/login", Role.NOBODY, self._log_in, blocking=True),
            Route("POST", "/api/logout", Role.WATCH, lambda _call: Cookie("")),
            Route("GET", "/api/me", Role.NOBODY, self._who),
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

    def files(self, static: Path) -> Mapping[str, File]:
        """Return the files of a folder by their paths; index.html has what it needs in itself."""

        def put_in(found: Match[str]) -> str:
            text = (static / found[2]).read_text("utf-8")
            return f"<script>{text}</script>" if found[1] else f"<style>{_colours()}{text}</style>"

        html = PARTS.sub(put_in, (static / "index.html").read_text("utf-8"))
        # With their fields, which the script fills in; nothing in them ends the element.
        words = json_text({one.value: self._words(one) for one in languages()})
        html = html.replace(WORDS_BEGIN, WORDS_BEGIN + words.replace("<", "\\u003c"))
        return {
            "/": File(html.encode(), "text/html; charset=UTF-8"),
            "/icon.svg": File((static / "icon.svg").read_bytes(), "image/svg+xml"),
            "/manifest.json": File((static / "manifest.json").read_bytes(), "application/json"),
        }

    def _words(self, language: Language) -> Mapping[str, Any]:
        words, text = dict(WORDS), read_catalogue(language).text
        for name, page in self.pages.items():
            words.update({f"{name}.{key}": one for key, one in page.words.items()})
        return {"own": language.own_name, "words": {name: text(one) for name, one in words.items()}}

    def _log_in(self, call: Call) -> Cookie:
        name, password = text_of(call, "name"), text_of(call, "password")
        person = self._logins.begin(name, password, call.address)
        return Cookie(person.session, _me(person))

    @staticmethod
    def _who(call: Call) -> Mapping[str, Any]:
        return {"me": None if call.person is None else _me(call.person)}

    def _live(self, call: Call) -> Callable[[], Document]:
        return lambda: self.document(call.language)


def _me(person: Person) -> Mapping[str, Any]:
    return {"name": person.name, "role": int(person.role), "mark": person.mark}


def _colours() -> str:
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
    return "\n".join(sheets)


def _name(name: str) -> str:
    return name.lower().replace("_", "-")
