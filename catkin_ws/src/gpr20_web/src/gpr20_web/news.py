"""What a person must learn who is not looking."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message


class Occasion(enum.Enum):
    """What happened; the most urgent first."""

    NO_CONTACT = "no_contact"
    FAULT = "fault"
    PAUSED = "paused"
    FINISHED = "finished"


@dataclass(frozen=True)
class News:
    """A notice.

    Attributes:
        number: Another one for each.
        remedy: What to do first; None: nothing.
        percent: How much of the survey is stored; None: there is none.
        picture: PNG of the map; None: there is none.
    """

    number: int
    occasion: Occasion
    title: Message
    text: Message
    remedy: Optional[Message] = None
    percent: Optional[int] = None
    picture: Optional[bytes] = None
