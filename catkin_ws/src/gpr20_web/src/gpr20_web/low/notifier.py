"""Notices by e-mail, MQTT and whatever else apprise knows; sending without anybody waiting for it.

Its URLs are secrets.
"""

from __future__ import annotations

import contextlib
import logging
import queue
import threading
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Generic, List, Optional, Sequence, Tuple, TypeVar

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_web.errors import NotNowError
from gpr20_web.faults import NOT_SENT

Thing = TypeVar("Thing")
FIRST_DELAY_S, LONGEST_DELAY_S = 20.0, 300.0
# The first one, and three more.
TRIES = 4
# They write addresses, which are secrets here, into their logs.
TALKATIVE = ("apprise", "urllib3", "requests", "slixmpp")


class Outbox(Generic[Thing]):
    """Sends in the order in which it was given; what fails is tried again behind the others.

    It has a thread of its own.

    Args:
        send: Sends one thing; OSError and Gpr20Error: it did not succeed.
        failure: What did not succeed, for the report.
        report: Takes each new problem, in that thread.
        delay_s: After a failure [s]; twice as long after each that follows, to 5 min.
        tries: How often a thing is tried.

    Attributes:
        problem: Why the last try did not succeed; None if it did.
    """

    def __init__(
        self,
        send: Callable[[Thing], None],
        failure: Message,
        report: Callable[[Message], None],
        delay_s: float = FIRST_DELAY_S,
        tries: int = TRIES,
    ) -> None:
        self._send, self._failure, self._report = send, failure, report
        self._delay_s, self._tries = delay_s, tries
        self._things: queue.Queue[Optional[Tuple[Thing, int]]] = queue.Queue()
        self._ended = threading.Event()
        self.problem: Optional[Message] = None
        self._thread = threading.Thread(target=self._work, name="outbox", daemon=True)
        self._thread.start()

    def put(self, thing: Thing) -> None:
        """Send a thing later."""
        self._things.put((thing, self._tries))

    def close(self, limit_s: float) -> None:
        """Try once more to send what waits, for at most so long [s]; then no more."""
        self._ended.set()
        self._things.put(None)
        self._thread.join(limit_s)

    def _work(self) -> None:
        failures = 0
        for thing, tries in iter(self._things.get, None):
            failures += 1
            with faults_logged("outbox"):
                if self._is_sent(thing):
                    failures = 0
                    continue
                if tries > 1:
                    self._things.put((thing, tries - 1))
                self._ended.wait(min(self._delay_s * 2.0 ** min(failures - 1, 20), LONGEST_DELAY_S))

    def _is_sent(self, thing: Thing) -> bool:
        former = self.problem
        try:
            self._send(thing)
        except (OSError, Gpr20Error) as error:
            reason = error.message if isinstance(error, Gpr20Error) else os_reason(error)
            self.problem = Message("{failure}: {reason}", failure=self._failure, reason=reason)
            if former is None:
                self._report(self.problem.with_fault(NOT_SENT))
            return False
        self.problem = None
        return True


@dataclass(frozen=True)
class News:
    """A notice.

    Attributes:
        kind: As apprise calls it: failure, warning or success.
        remedy: What to do first; None: nothing.
    """

    kind: str
    title: Message
    text: Message
    remedy: Optional[Message] = None


class Notifier:
    """Sends notices later, to each address by itself.

    Args:
        urls: Addresses as apprise has them; one that it does not know is reported and left out.
        name: Of the robot or the site, in front of each title.
        text: Returns a sentence in the language of the site.
        report: Takes what did not succeed, later in one of the threads; without addresses.
    """

    def __init__(
        self,
        urls: Sequence[str],
        name: str,
        text: Callable[[Message], str],
        report: Callable[[Message], None],
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
            self._boxes.append(Outbox(partial(self._deliver, server), failure, report))

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
        title, is_sent = f"{self._name}: {self._text(news.title)}", False
        with contextlib.suppress(Exception):  # of any of a hundred plugins; it may say the address
            is_sent = bool(server.notify(title=title, body=body, notify_type=news.kind))
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
