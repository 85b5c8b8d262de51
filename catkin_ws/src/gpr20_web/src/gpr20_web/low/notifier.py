"""Notices by e-mail, MQTT and whatever else apprise knows. Its URLs are secrets."""

from __future__ import annotations

import enum
import logging
import threading
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Sequence

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_web.errors import NotSentError
from gpr20_web.low.outbox import Outbox

LIMIT_S = 60.0
FIRST_DELAY_S = 20.0
# The first one, and three more.
TRIES = 4


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


TYPES = {
    Occasion.NO_CONTACT: "failure",
    Occasion.FAULT: "failure",
    Occasion.PAUSED: "warning",
    Occasion.FINISHED: "success",
}
# They write addresses, which are secrets here, into their logs.
TALKATIVE = ("apprise", "urllib3", "requests", "slixmpp")


class Notifier:
    """Sends notices in threads of its own, one for each address.

    Args:
        urls: Addresses as apprise has them; one that it does not know is reported and left out.
        name: Of the robot or the site, in front of each title.
        text: Returns a sentence in the language of the site.
        report: Takes what did not succeed, later in one of the threads; without addresses.
        delay_s: Before the second try [s].
        limit_s: For one try [s].
    """

    def __init__(
        self,
        urls: Sequence[str],
        name: str,
        text: Callable[[Message], str],
        report: Callable[[Message], None],
        delay_s: float = FIRST_DELAY_S,
        limit_s: float = LIMIT_S,
    ) -> None:
        for one in TALKATIVE:
            logger = logging.getLogger(one)
            logger.handlers, logger.propagate = [logging.NullHandler()], False
        self._name, self._text, self._limit_s = name, text, limit_s
        servers: Dict[int, Any] = {}
        for number, url in enumerate(urls, 1):
            server = _server(url)
            if server is not None:
                servers[number] = server
                continue
            words = Message(
                "apprise does not know address {number} of notify.txt; it gets no notices",
                number=number,
            )
            report(words.with_fault(CONFIGURATION.as_warning()))
        self._boxes: List[Outbox[News]] = [
            Outbox(
                partial(self._deliver, server),
                Message("no notice could be sent to address {number} of notify.txt", number=number),
                report,
                delay_s,
                TRIES,
            )
            for number, server in servers.items()
        ]

    def send(self, news: News) -> None:
        """Send a notice later, to every address."""
        for box in self._boxes:
            box.put(news)

    def close(self, limit_s: float) -> None:
        """Send what waits, in at most so long for each address [s]."""
        for box in self._boxes:
            box.close(limit_s)

    def _deliver(self, server: Any, news: News) -> None:
        done: List[bool] = []
        # A name server or a mail server may hang for minutes; the thread ends with the process.
        worker = threading.Thread(
            target=lambda: done.append(self._notify(server, news)), daemon=True
        )
        worker.start()
        worker.join(self._limit_s)
        if worker.is_alive():
            raise TimeoutError
        if done != [True]:
            raise NotSentError(Message("the service did not accept it, or does not answer"))

    def _notify(self, server: Any, news: News) -> bool:
        lines = [self._text(one) for one in (news.text, news.remedy) if one is not None]
        if news.percent is not None:
            lines.append(f"{news.percent} %")
        words = {
            "title": f"{self._name}: {self._text(news.title)}",
            "body": "\n".join(one[:1].upper() + one[1:] for one in lines),
            "notify_type": TYPES[news.occasion],
        }
        try:
            if news.picture is not None and server.attachment_support:
                words["attach"] = _attached(news.picture)
            return bool(server.notify(**words))
        except Exception:  # of any of a hundred plugins; its text may have the address in it
            return False


def _attached(picture: bytes) -> Any:
    import apprise
    from apprise.attachment.memory import AttachMemory

    return apprise.AppriseAttachment(AttachMemory(picture, "map.png", "image/png"))


def _server(url: str) -> Any:
    # It takes 40 MB of memory: only where somebody is notified.
    import apprise

    asset = apprise.AppriseAsset(app_id="GPR-20", async_mode=False)
    try:
        return apprise.Apprise.instantiate(url, asset=asset, suppress_exceptions=True)
    except Exception:  # as above
        return None
