"""What the robot's screen says before there is a window: deploy/waiting_screen.py."""

from __future__ import annotations

import subprocess
import sys
from xmlrpc.server import SimpleXMLRPCServer

from user_shell import ROOT


def test_it_becomes_the_window_when_the_master_answers(monkeypatch):
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as master:
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{master.server_address[1]}")
        monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
        # A program that has ended asks nothing.
        master.timeout = 30.0
        answers = iter([(-1, "not yet", 0), (1, "", 7)])
        master.register_function(lambda caller: next(answers), "getPid")
        program = (sys.executable, str(ROOT / "deploy/waiting_screen.py"), "echo", "window")
        with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as screen:
            master.handle_request()
            assert screen.poll() is None
            master.handle_request()
            assert screen.communicate()[0] == "window\n"
