"""The short form of the crash matrix; docs/reliability.md has the figures of the long one."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.real_time, pytest.mark.takes(150)]

MATRIX = Path(__file__).resolve().parents[1] / "crash_matrix"
KILLS = 20
LIMIT_S = 600.0


def test_twenty_kills_lose_double_and_falsify_nothing():
    ended = subprocess.run(
        [sys.executable, str(MATRIX), "--kills", str(KILLS), "--seed", "1"],
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    (figures,) = re.findall(
        r"(\d+) kills in \d+ s, (\d+) surveys, .* (\d+) acknowledged traces, (\d+) faults",
        ended.stdout,
    )
    kills, surveys, acknowledged, faults = map(int, figures)
    assert kills >= KILLS
    assert acknowledged >= surveys
    assert faults == 0
