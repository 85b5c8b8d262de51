"""What the watchdog reports to systemd when it ends."""

import os

import pytest

pytest.importorskip("rosgraph")

from gpr20_launch.high import watchdog


class Program:
    """The program under a roslaunch, with a watchdog of the test."""

    def __init__(self, monkeypatch, looks):
        self.said, self._looks = [], list(looks)
        self.complete = True
        monkeypatch.setattr(watchdog.rosgraph, "myargv", lambda: ["", "--launch=/l", "--limit=9"])
        monkeypatch.setattr(watchdog, "process_info", lambda _number: self)
        monkeypatch.setattr(watchdog.signal, "signal", lambda *_all: None)
        monkeypatch.setattr(watchdog, "enable_line_buffering", lambda: None)
        monkeypatch.setattr(watchdog, "Watchdog", lambda *_all: self)
        monkeypatch.setattr(watchdog, "service_manager", lambda: self)
        monkeypatch.setattr(watchdog, "PERIOD_S", 0.0)
        self._monkeypatch = monkeypatch

    is_roslaunch = True

    def look(self):
        look = self._looks.pop(0)
        if not self._looks:
            self._monkeypatch.setattr(os, "getppid", lambda: 1)
        if look is not None:
            raise look

    def keep_alive(self, _limit_s):
        self.said.append("alive")

    def release(self):
        self.said.append("released")


def test_systemd_guards_no_longer_when_the_launch_has_ended(monkeypatch):
    program = Program(monkeypatch, [None, None])
    assert watchdog.main() == 0
    assert program.said == ["alive", "alive", "released"]


def test_systemd_guards_on_after_an_error(monkeypatch):
    program = Program(monkeypatch, [None, ZeroDivisionError()])
    with pytest.raises(ZeroDivisionError):
        watchdog.main()
    assert program.said == ["alive"]
