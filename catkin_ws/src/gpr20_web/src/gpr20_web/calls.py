"""What a page is, what its script asks and gets: the table of routes is made of these."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Optional, Tuple, Union

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.message import Message
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.faults import BadRequestError

Text = Callable[[Message], str]
"""Translates a message into the language of a browser."""
# Of a text that a page sends.
MOST_CHARACTERS = 2000


class Role(enum.IntEnum):
    """What a person may do; each role may do all of those before it."""

    NOBODY = 0
    """Not logged in."""
    WATCH = 1
    """Watches, adds notes and markers, pauses and stops."""
    CONTROL = 2
    """Also starts and resumes, while somebody at the robot allows it."""

    @property
    def word(self) -> str:
        """What it is called in files and on the command line."""
        return self.name.lower()


# What an account can have, by its word.
ROLES = {one.word: one for one in (Role.WATCH, Role.CONTROL)}


@dataclass(frozen=True)
class Person:
    """Somebody who is logged in, from one browser.

    Attributes:
        name: Of the account.
        session: Secret of the session; it leaves the server only in the cookie.
        address: Where the request came from.
    """

    name: str
    role: Role
    session: str
    address: str

    @property
    def mark(self) -> str:
        """By which a browser knows itself; the secret of its session stays with the server."""
        return sha256(self.session.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Call:
    """A request that was checked: its person has the right of its route.

    Attributes:
        person: Who asks; None, only for routes of Role.NOBODY: it is not known.
        address: Where the request came from.
        values: The JSON object of a POST, or the query of a GET.
        parts: What the pattern of the path names.
    """

    person: Optional[Person] = None
    address: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    parts: Mapping[str, str] = field(default_factory=dict)
    language: Language = Language.ENGLISH

    @property
    def text(self) -> Text:
        """Translates into the language of the browser."""
        return read_catalogue(self.language).text

    @property
    def who(self) -> Person:
        """The person; the server has checked that there is one."""
        if self.person is None:
            raise LookupError("this route is for persons who are logged in")
        return self.person


def text_of(call: Call, name: str) -> str:
    """Return a text that a page has sent; empty if it has sent none.

    Raises:
        BadRequestError: It is no text, or a long one.
    """
    value = call.values.get(name, "")
    if isinstance(value, str) and len(value) <= MOST_CHARACTERS:
        return value
    raise BadRequestError(
        Message("{name} is a text of at most {most} characters", name=name, most=MOST_CHARACTERS)
    )


def sentence(text: Text, message: Optional[Message]) -> str:
    """Return a message as a sentence of its own; empty without one."""
    shown = "" if message is None else text(message)
    return shown[:1].upper() + shown[1:]


@dataclass(frozen=True)
class Body:
    """An answer that is no JSON object.

    Attributes:
        content: Bytes, or parts of them as they are made.
        kind: Media type.
        name: Of the file that the browser saves; empty: it shows the content.
    """

    content: Union[bytes, Iterator[bytes]]
    kind: str
    name: str = ""


class File(NamedTuple):
    """What a browser loads before all else; the kind is its media type."""

    content: bytes
    kind: str


@dataclass(frozen=True)
class Cookie:
    """A JSON answer that sets the cookie of the browser; empty: it forgets it."""

    session: str
    values: Mapping[str, Any] = field(default_factory=dict)


class Document(NamedTuple):
    """What a browser shows, as members of a JSON object, each with a comma behind it.

    Attributes:
        urgent: Sent as soon as it changes.
        seldom: What changes all the time: it alone is sent once a second.
    """

    urgent: str
    seldom: str = ""


Answer = Union[Mapping[str, Any], Body, Cookie, Callable[[], Document]]
"""A function returns what a person sees now: it is sent as long as the person watches."""


@dataclass(frozen=True)
class Route:
    """One thing that a browser can ask for.

    Attributes:
        method: GET or POST; GET changes nothing.
        pattern: Of the whole path, as tornado has it; its named groups are `Call.parts`.
        right: The least role.
        answer: Makes the answer.
        blocking: Whether it waits for files or nodes: then it runs in a thread of its own.
    """

    method: str
    pattern: str
    right: Role
    answer: Callable[[Call], Answer]
    blocking: bool = False


class WebPage:
    """One page; all but its blocking routes is called in the thread of the server.

    Attributes:
        routes: What its script asks for.
        words: The sentences of its script by their names, in every language of the catalogue.
    """

    routes: Tuple[Route, ...] = ()
    words: Mapping[str, Message] = {}

    def on_event(self, event: object) -> None:
        """Take an event of the robot; most are about something else."""

    def show_state(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""

    def live(self, text: Text) -> Mapping[str, Any]:
        """Return its part of what every browser is sent as it changes."""
        return {}
