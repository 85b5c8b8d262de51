"""The programs of deploy/, imported."""

from __future__ import annotations

import importlib
import sys

from user_shell import ROOT


def imported(name):
    """Return a module of deploy/, which are run as programs, from their folder."""
    sys.path.insert(0, str(ROOT / "deploy"))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(ROOT / "deploy"))
