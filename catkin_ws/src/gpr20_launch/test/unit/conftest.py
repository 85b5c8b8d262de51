import sys

import pytest


@pytest.fixture
def run(monkeypatch, capfd):
    """Return a function that runs a program and returns its status and what it printed."""

    def run(module, *arguments):
        main = pytest.importorskip(f"gpr20_launch.high.{module}").main
        monkeypatch.setattr(sys, "argv", [module, *map(str, arguments)])
        return (main(), *capfd.readouterr())

    return run
