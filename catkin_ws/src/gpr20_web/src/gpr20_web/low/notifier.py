"""Notices by e-mail, MQTT and whatever else apprise knows. Its URLs are secrets."""

from __future__ import annotations

import contextlib
import enum
import logging
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, List, Optional, Sequence

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_web.errors import NotNowError
from gpr20_web.faults import NOT_SENT
from gpr20_web.low.outbox import Outbox

FIRST_DELAY_S = 20.0
# The first one, and three more.
TRIES = 4
# They write addresses, which are secrets here, into their logs.
TALKATIVE = ("apprise", "urllib3", "requests", "slixmpp")


class Occasion(enum.Enum):
    """What happened; the most urgent first."""

    NO_CONTACT = "no_contact"
    FAULT = "fault"
    PAUSED = "paused"
    FINISHED = "finished"


# As apprise calls them.
TYPES = {Occasion.PAUSED: "warning", Occasion.FINISHED: "success"}


@dataclass(frozen=True)
class News:
    """A notice.

    Attributes:
        number: Another one for each.
        remedy: What to do first; None: nothing.
    """

    number: int
    occasion: Occasion
    title: Message
    text: Message
    remedy: Optional[Message] = None


class Notifier:
    """Sends notices in threads of its own, one for each address.

    Args:
        urls: Addresses as apprise has them; one that it does not know is reported and left out.
        name: Of the robot or the site, in front of each title.
        text: Returns a sentence in the language of the site.
        report: Takes what did not succeed, later in one of the threads; without addresses.
        delay_s: Before the second try [s].
    """

    def __init__(
        self,
        urls: Sequence[str],
        name: str,
        text: Callable[[Message], str],
        report: Callable[[Message], None],
        delay_s: float = FIRST_DELAY_S,
    ) -> None:
        for one in TALKATIVE:
            logger = logging.getLogger(one)
            logger.handlers, logger.propagate = [logging.NullHandler()], False
        self._name, self._text = name, text
        self._boxes: List[Outbox[News]] = []
        for number, url in enumerate(urls, 1):
            server = _server(url)
            if server is None:
                words = Message(
                    "apprise does not know address {number} of notify.txt; it gets no notices",
                    number=number,
                )
                report(words.with_fault(CONFIGURATION.as_warning()))
                continue
            failure = Message(
                "no notice could be sent to address {number} of notify.txt", number=number
            )
            send = partial(self._deliver, server)
            self._boxes.append(Outbox(send, failure, report, delay_s, TRIES))

    def send(self, news: News) -> None:
        """Send a notice later, to every address."""
        for box in self._boxes:
            box.put(news)

    def close(self, limit_s: float) -> None:
        """Send what waits, in at most so long for each address [s]."""
        for box in self._boxes:
            box.close(limit_s)

    def _deliver(self, server: Any, news: News) -> None:
        lines = [self._text(one) for one in (news.text, news.remedy) if one is not None]
        body = "\n".join(one[:1].upper() + one[1:] for one in lines)
        title, kind = f"{self._name}: {self._text(news.title)}", TYPES.get(news.occasion, "failure")
        is_sent = False
        with contextlib.suppress(Exception):  # of any of a hundred plugins; it may say the address
            is_sent = bool(server.notify(title=title, body=body, notify_type=kind))
        if not is_sent:
            refusal = Message("the service did not accept it, or does not answer")
            raise NotNowError(refusal, fault=NOT_SENT)


def _server(url: str) -> Any:
    # It takes 40 MB of memory: only where somebody is notified.
    import apprise

    asset = apprise.AppriseAsset(app_id="GPR-20", async_mode=False)
    try:
        return apprise.Apprise.instantiate(url, asset=asset, suppress_exceptions=True)
    except Exception:  # as above
        return None
