"""The wings: packages whose folders can be deleted; tests that need one are skipped then."""

from __future__ import annotations

from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2] / "catkin_ws/src"
WINGS = ("gpr20_foreign_formats", "gpr20_scikit_rf", "gpr20_viewer")


def needs(*wings: str) -> pytest.MarkDecorator:
    """Return the mark of a test that needs wings."""
    absent = [one for one in wings if not (SOURCES / one).is_dir()]
    return pytest.mark.skipif(bool(absent), reason=f"absent: {', '.join(absent)}")


NEEDS_ALL = needs(*WINGS)
"""Mark of a test of the whole repository: its tables and links are also about the wings."""
