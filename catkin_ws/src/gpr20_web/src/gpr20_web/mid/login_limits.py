"""How often somebody may guess a password: one limit for each account and address."""

from __future__ import annotations

import contextlib
import math
import threading
from collections import OrderedDict
from typing import Iterator, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.errors import BusyError, TooManyLoginsError, WrongLoginError

FREE_FAILURES = 5
# From then on, after each failure [s].
WAIT_S = 60.0
# Accounts and addresses of which failures are known.
MOST_KNOWN = 1000
CHECKS_AT_ONCE = 4


class LoginLimits:
    """Counts failed logins by account and address; any thread may use it.

    Others who guess at another address do not keep an account's owner out.

    Args:
        clock: Measures the delays.
    """

    def __init__(self, clock: Clock) -> None:
        self._now_s = clock.now_s
        self._lock = threading.Lock()
        self._slots = threading.BoundedSemaphore(CHECKS_AT_ONCE)
        # How often, and when last; the one that failed longest ago is forgotten first.
        self._failures: OrderedDict[Tuple[str, str], Tuple[int, float]] = OrderedDict()

    @contextlib.contextmanager
    def attempt(self, name: str, address: str) -> Iterator[None]:
        """Check a password inside; WrongLoginError there is a failure, success clears the count.

        After another error, as of a damaged file of accounts, nothing has changed.

        Args:
            name: What was given, also if there is no such account.
            address: Where the request came from.

        Raises:
            TooManyLoginsError: It is too early; nothing was checked.
            BusyError: Too many are checked now.
        """
        key = name.lower()[:40], address
        with self._lock:
            now_s = self._now_s()
            count, last_s = self._failures.get(key, (0, -math.inf))
            wait_s = last_s + WAIT_S - now_s
            if count >= FREE_FAILURES and wait_s > 0.0:
                seconds = math.ceil(wait_s)
                raise TooManyLoginsError(
                    Message("too many logins failed; wait {seconds} s", seconds=seconds)
                )
            if not self._slots.acquire(blocking=False):
                raise BusyError(
                    Message("{count} people log in at this moment; wait", count=CHECKS_AT_ONCE)
                )
            # Before it has failed: several at once would else be several guesses.
            self._note(key, count + 1, now_s)
        try:
            yield
        except WrongLoginError:
            raise
        except BaseException:
            with self._lock:
                now, _failed_s = self._failures.get(key, (1, last_s))
                self._note(key, now - 1, last_s)
            raise
        else:
            with self._lock:
                self._failures.pop(key, None)
        finally:
            self._slots.release()

    def _note(self, key: Tuple[str, str], count: int, last_s: float) -> None:
        self._failures.pop(key, None)
        if count:
            self._failures[key] = count, last_s
        if len(self._failures) > MOST_KNOWN:
            self._failures.popitem(last=False)
