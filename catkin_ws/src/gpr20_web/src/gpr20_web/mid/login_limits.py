"""How often somebody may guess: each failed login makes the next one wait longer."""

from __future__ import annotations

import contextlib
import math
import threading
from collections import OrderedDict
from typing import Generic, Iterator, Tuple, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.errors import BusyError, TooManyLoginsError, WrongLoginError

FREE_FAILURES = 3
LONGEST_DELAY_S = 300.0
# Without another failure they are forgotten after so long [s].
FORGOTTEN_S = 3600.0
# Names, and addresses, of which failures are known; and logins that have succeeded.
MOST_KNOWN = 1000
CHECKS_AT_ONCE = 4
# A name and an address from which it has logged in before; from all others the address is empty.
Login = Tuple[str, str]
Key = TypeVar("Key")
Value = TypeVar("Value")


class LoginLimits:
    """Counts failed logins by name and by address; any thread may use it.

    An address from which a name has logged in before has a count of its own for it: others who
    guess do not keep its owner out.

    Args:
        clock: Measures the delays.
    """

    def __init__(self, clock: Clock) -> None:
        self._now_s = clock.now_s
        self._lock = threading.Lock()
        self._slots = threading.BoundedSemaphore(CHECKS_AT_ONCE)
        self._names: _Failures[Login] = _Failures()
        self._addresses: _Failures[str] = _Failures()
        self._succeeded: OrderedDict[Login, None] = OrderedDict()

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
            own = name, address
            login = own if own in self._succeeded else (name, "")
            wait_s = max(self._names.wait_s(login, now_s), self._addresses.wait_s(address, now_s))
            if wait_s > 0.0:
                seconds = math.ceil(wait_s)
                raise TooManyLoginsError(
                    Message("too many logins failed; wait {seconds} s", seconds=seconds)
                )
            if not self._slots.acquire(blocking=False):
                raise BusyError(
                    Message("{count} people log in at this moment; wait", count=CHECKS_AT_ONCE)
                )
            # Before it has failed: several at once would else be several guesses.
            self._names.add(login, now_s)
        try:
            yield
            with self._lock:
                self._names.clear(login)
                _put_last(self._succeeded, own, None)
        except WrongLoginError:
            with self._lock:
                self._addresses.add(address, self._now_s())
            raise
        finally:
            self._slots.release()


class _Failures(Generic[Key]):
    """How often each failed, and when last; the one that failed longest ago is forgotten first."""

    def __init__(self) -> None:
        self._known: OrderedDict[Key, Tuple[int, float]] = OrderedDict()

    def wait_s(self, key: Key, now_s: float) -> float:
        """Return how long the next attempt must wait [s]."""
        count, last_s = self._known.get(key, (0, now_s))
        if now_s - last_s >= FORGOTTEN_S:
            self.clear(key)
            return 0.0
        if count < FREE_FAILURES:
            return 0.0
        return last_s + min(2.0 ** min(count - FREE_FAILURES, 60), LONGEST_DELAY_S) - now_s

    def add(self, key: Key, now_s: float) -> None:
        """Add a failure."""
        count, _last_s = self._known.get(key, (0, now_s))
        _put_last(self._known, key, (count + 1, now_s))

    def clear(self, key: Key) -> None:
        """Forget it."""
        self._known.pop(key, None)


def _put_last(known: OrderedDict[Key, Value], key: Key, value: Value) -> None:
    known.pop(key, None)
    known[key] = value
    if len(known) > MOST_KNOWN:
        known.popitem(last=False)
