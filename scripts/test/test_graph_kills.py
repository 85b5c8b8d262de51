"""The kills in the ROS graph for a release; docs/evidence/reliability.md has figures of more."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from run_seed import SEED

SUITE = Path(__file__).resolve().parents[1] / "fault_suite.sh"


@pytest.mark.release
def test_kills_in_the_graph_lose_double_and_falsify_nothing(tmp_path):
    command = [SUITE, "--only", "graph", "--count", "5", "--seed", SEED, "--data", tmp_path]
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert ended.returncode == 0, f"seed {SEED}: {ended.stdout}{ended.stderr}"
    assert list(tmp_path.iterdir()) == []
