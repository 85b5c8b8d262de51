"""Clocks whose time passes faster, or is set by a test."""

from __future__ import annotations

import time

from gpr20_common.low.clock import Clock


class FastClock(Clock):
    """A thousand seconds pass in each real one."""

    FACTOR = 1000.0

    def __init__(self):
        # What a test has set the time of day forward by, against the passing seconds.
        self.set_s = 1.8e9

    def time_of_day_us(self):
        return round(1e6 * (self.now_s() + self.set_s))

    def now_s(self):
        return time.monotonic() * self.FACTOR

    def wait_s(self, event, timeout_s):
        return event.wait(timeout_s / self.FACTOR)


class ManualClock(Clock):
    """A test sets the time; each wait ends at once and takes a little of it."""

    def __init__(self):
        self.time_s = 0.0
        self.waits_s = []
        self.set_s = 1.8e9

    def time_of_day_us(self):
        return round(1e6 * (self.time_s + self.set_s))

    def now_s(self):
        return self.time_s

    def wait_s(self, event, timeout_s):
        self.waits_s.append(timeout_s)
        self.time_s += 0.01
        return event.wait(0.001)
