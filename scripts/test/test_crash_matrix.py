"""The crash matrix for a release; docs/evidence/reliability.md has figures of the long one."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from run_seed import SEED

pytestmark = pytest.mark.release
MATRIX = Path(__file__).resolve().parents[2] / "tools/crash_matrix"
NOT_POSSIBLE = 77


@pytest.mark.parametrize(
    ("name", "kills", "cuts"),
    [
        # One of each kind, and another one.
        ("process kills", 5, 0),
        ("power cuts", 0, 2),
    ],
)
def test_kills_and_cuts_lose_double_and_falsify_nothing(name, kills, cuts):
    command = [sys.executable, MATRIX, "--seed", SEED, "--kills", kills, "--power-cuts", cuts]
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if ended.returncode == NOT_POSSIBLE:
        pytest.skip(ended.stdout.strip())
    assert ended.returncode == 0, f"seed {SEED}: {ended.stdout}{ended.stderr}"
    (figures,) = re.findall(
        rf"(\d+) {name} in \d+ s, (\d+) surveys, .* (\d+) acknowledged traces, (\d+) faults",
        ended.stdout,
    )
    done, surveys, acknowledged, faults = map(int, figures)
    assert done >= kills + cuts
    assert acknowledged >= surveys
    assert faults == 0
