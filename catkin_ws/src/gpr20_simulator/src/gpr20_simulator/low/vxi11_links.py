"""The links of a VXI-11 server: who is connected, who holds the lock, who waits for what."""

from __future__ import annotations

import contextlib
import itertools
import threading
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Callable, Deque, Dict, Iterator, List, Optional

from gpr20_simulator.low.rpc import Caller
from gpr20_simulator.low.vxi11_protocol import Error, Flag

# How soon a waiting call notices that its client has gone.
GONE_POLL_S = 0.2
MOST_UNREAD_ANSWERS = 64
MOST_UNREAD_BYTES = 4 << 20


class LinkError(Exception):
    """A call cannot go on; carries the code that the client gets."""

    def __init__(self, code: Error) -> None:
        super().__init__(code.name)
        self.code = code


@dataclass(eq=False)
class Link:
    """One client's link to the device.

    Attributes:
        number: The link identifier on the wire.
        owner: The connection it was created on.
        incoming: What has been written since the last END.
        outgoing: Answers not read yet, oldest first; each ends with END.
        late: Answers that cannot be read before the next message.
    """

    number: int
    owner: Caller
    incoming: bytearray = field(default_factory=bytearray)
    # An unread answer stays in front of the next one: a client that missed an answer and
    # continues reads the wrong one, as it would on an instrument.
    outgoing: Deque[bytes] = field(default_factory=deque)
    late: List[bytes] = field(default_factory=list)
    is_busy: bool = False
    is_aborted: bool = False

    def queue(self, answer: bytes) -> None:
        """Put an answer behind those not read yet; the oldest ones are lost if they are many."""
        self.outgoing.append(answer)
        while len(self.outgoing) > MOST_UNREAD_ANSWERS or (
            len(self.outgoing) > 1 and sum(map(len, self.outgoing)) > MOST_UNREAD_BYTES
        ):
            self.outgoing.popleft()


class LinkBook:
    """All links of one server; every method may be called from any thread.

    Args:
        most_links: Further clients get the error "out of resources".
    """

    def __init__(self, most_links: int) -> None:
        self._most_links = most_links
        self._changed = threading.Condition()
        self._links: Dict[int, Link] = {}
        self._numbers = itertools.count(1)
        self._lock_holder: Optional[Link] = None

    def __len__(self) -> int:
        with self._changed:
            return len(self._links)

    def create(self, owner: Caller, lock_timeout_s: Optional[float]) -> Link:
        """Make a link.

        Args:
            owner: The connection that asks.
            lock_timeout_s: How long to wait for the lock [s]; None: the lock is not wanted.

        Raises:
            LinkError: There are too many links, or another one keeps the lock.
        """
        with self._changed:
            if len(self._links) >= self._most_links:
                raise LinkError(Error.OUT_OF_RESOURCES)
            link = Link(next(self._numbers) & 0x7FFFFFFF, owner)
            if lock_timeout_s is not None:
                self._wait_for_lock(link, lock_timeout_s)
                self._lock_holder = link
            self._links[link.number] = link
            return link

    @contextlib.contextmanager
    def call(self, number: int, owner: Caller) -> Iterator[Link]:
        """Give the link to a call in progress, which an abort can end meanwhile.

        Raises:
            LinkError: The connection has no such link.
        """
        with self._changed:
            link = self._links.get(number)
            if link is None or link.owner is not owner:
                raise LinkError(Error.INVALID_LINK)
            link.is_busy, link.is_aborted = True, False
        try:
            yield link
        finally:
            with self._changed:
                link.is_busy = False

    def check_access(self, link: Link, flags: int, lock_timeout_s: float) -> None:
        """Return once no other link holds the lock.

        Raises:
            LinkError: Another link holds it, and the flags say not to wait or the time is over.
        """
        with self._changed:
            self._wait_for_lock(link, lock_timeout_s if flags & Flag.WAIT_LOCK else 0.0)

    def lock(self, link: Link, flags: int, lock_timeout_s: float) -> None:
        """Take the lock; it does not nest.

        Raises:
            LinkError: Some link, this one included, holds it already.
        """
        with self._changed:
            if self._lock_holder is link:
                raise LinkError(Error.LOCKED_BY_ANOTHER)
            self._wait_for_lock(link, lock_timeout_s if flags & Flag.WAIT_LOCK else 0.0)
            self._lock_holder = link

    def unlock(self, link: Link) -> None:
        """Give the lock back.

        Raises:
            LinkError: This link does not hold it.
        """
        with self._changed:
            if self._lock_holder is not link:
                raise LinkError(Error.NO_LOCK_HELD)
            self._free_lock(link)

    def wait_for_answer(self, link: Link, timeout_s: float) -> None:
        """Return once there is something to read.

        Raises:
            LinkError: The time is over, the call was aborted or the client is gone.
        """
        with self._changed:
            if not self._wait(link, lambda: bool(link.outgoing), timeout_s):
                raise LinkError(Error.IO_TIMEOUT)

    def abort(self, number: int) -> None:
        """End the call in progress on a link, if there is one.

        Raises:
            LinkError: There is no such link.
        """
        with self._changed:
            link = self._links.get(number)
            if link is None:
                raise LinkError(Error.INVALID_LINK)
            link.is_aborted = link.is_busy
            self._changed.notify_all()

    def destroy(self, link: Link) -> None:
        """Remove a link and free its lock."""
        with self._changed:
            self._links.pop(link.number, None)
            self._free_lock(link)

    def destroy_all_of(self, owner: Caller) -> None:
        """Remove every link of a connection and free their locks."""
        with self._changed:
            owned = [link for link in self._links.values() if link.owner is owner]
        for link in owned:
            self.destroy(link)

    def _free_lock(self, link: Link) -> None:
        if self._lock_holder is link:
            self._lock_holder = None
            self._changed.notify_all()

    def _wait_for_lock(self, link: Link, timeout_s: float) -> None:
        if not self._wait(link, lambda: self._lock_holder in (None, link), timeout_s):
            raise LinkError(Error.LOCKED_BY_ANOTHER)

    def _wait(self, link: Link, is_ready: Callable[[], bool], timeout_s: float) -> bool:
        deadline_s = time.monotonic() + timeout_s
        while not is_ready():
            if link.is_aborted:
                raise LinkError(Error.ABORTED)
            if link.owner.is_gone():
                raise LinkError(Error.IO_ERROR)
            remaining_s = deadline_s - time.monotonic()
            if remaining_s <= 0.0:
                return False
            self._changed.wait(min(remaining_s, GONE_POLL_S))
        return True
