"""How often somebody may guess: each failed login makes the next one wait longer."""

from __future__ import annotations

import contextlib
import math
import threading
from collections import OrderedDict
from typing import Iterator, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.errors import BusyError, TooManyLoginsError, WrongLoginError

FREE_FAILURES = 3
LONGEST_DELAY_S = 300.0
# Without another failure they are forgotten after so long [s].
FORGOTTEN_S = 3600.0
# Names, and addresses, of which failures are known.
MOST_KNOWN = 1000
CHECKS_AT_ONCE = 4


class LoginLimits:
    """Counts failed logins by name and by address; any thread may use it.

    Args:
        clock: Measures the delays.
    """

    def __init__(self, clock: Clock) -> None:
        self._now_s = clock.now_s
        self._lock = threading.Lock()
        self._slots = threading.BoundedSemaphore(CHECKS_AT_ONCE)
        self._names, self._addresses = _Failures(), _Failures()

    @contextlib.contextmanager
    def attempt(self, name: str, address: str) -> Iterator[None]:
        """Check a password inside; WrongLoginError there is a failure.

        Success clears the name but not the address: one's own account helps nobody to guess
        that of another.

        Args:
            name: What was given, also if there is no such account.
            address: Where the request came from.

        Raises:
            TooManyLoginsError: It is too early; nothing was checked.
            BusyError: Too many are checked now.
        """
        name = name.lower()[:40]
        with self._lock:
            now_s = self._now_s()
            wait_s = max(self._names.wait_s(name, now_s), self._addresses.wait_s(address, now_s))
            if wait_s > 0.0:
                seconds = math.ceil(wait_s)
                raise TooManyLoginsError(
                    Message("too many logins failed; wait {seconds} s", seconds=seconds)
                )
            if not self._slots.acquire(blocking=False):
                raise BusyError(Message("too many people log in at this moment"))
            # Before it has failed: several at once would else be several guesses.
            self._names.add(name, now_s)
        try:
            yield
            with self._lock:
                self._names.clear(name)
        except WrongLoginError:
            with self._lock:
                self._addresses.add(address, self._now_s())
            raise
        finally:
            self._slots.release()


class _Failures:
    """How often each failed, and when last; the one that failed longest ago is forgotten first."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, Tuple[int, float]] = OrderedDict()

    def wait_s(self, key: str, now_s: float) -> float:
        """Return how long the next attempt must wait [s]."""
        count, last_s = self._known.get(key, (0, now_s))
        if now_s - last_s >= FORGOTTEN_S:
            self.clear(key)
            return 0.0
        if count < FREE_FAILURES:
            return 0.0
        return last_s + min(2.0 ** min(count - FREE_FAILURES, 60), LONGEST_DELAY_S) - now_s

    def add(self, key: str, now_s: float) -> None:
        """Add a failure."""
        count, _last_s = self._known.pop(key, (0, now_s))
        self._known[key] = count + 1, now_s
        if len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)

    def clear(self, key: str) -> None:
        """Forget it."""
        self._known.pop(key, None)
