"""Images that are made beside the viewer's window, one at a time."""

from __future__ import annotations

import threading

import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtWidgets import QApplication
from test_view_window import LIMIT_S, until

from gpr20_viewer.session import ImageRequest
from gpr20_viewer.views.live_bridge import LiveBridge


class Gate:
    """A session whose images are made when the test says so."""

    def __init__(self):
        self.begun, self.free = threading.Event(), threading.Event()
        self.computed, self.image = [], None

    def compute(self, wanted, loop):
        self.computed.append(wanted.permittivity)
        self.begun.set()
        assert self.free.wait(LIMIT_S)
        if wanted.permittivity == 3.0:
            raise ValueError("as the test wants it")
        return next(iter(loop([self])))


def test_the_latest_request_is_computed_and_a_closed_bridge_says_nothing(application):
    gate = Gate()
    bridge, said = LiveBridge(gate), []
    bridge.computed.connect(lambda _image: said.append("computed"))
    bridge.failed.connect(lambda wanted, _error: said.append(wanted.permittivity))
    for permittivity in (1.0, 2.0, 3.0):
        bridge.request(ImageRequest(permittivity, False))
        assert gate.begun.wait(LIMIT_S)
    gate.free.set()
    until(lambda: said == ["computed", 3.0])
    bridge.request(ImageRequest(4.0, False))
    until(lambda: said == ["computed", 3.0, "computed"])
    gate.begun.clear()
    gate.free.clear()
    bridge.request(ImageRequest(5.0, False))
    assert gate.begun.wait(LIMIT_S)
    closing = threading.Thread(target=bridge.close)
    closing.start()
    until(bridge._closed.is_set)
    gate.free.set()
    closing.join(LIMIT_S)
    QApplication.processEvents()
    assert gate.computed == [1.0, 3.0, 4.0, 5.0] and len(said) == 3
