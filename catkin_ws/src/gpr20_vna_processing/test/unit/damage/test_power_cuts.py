"""The power of the disk is cut at random instants: nothing acknowledged is lost or wrong.

GPR20_POWER_CUTS sets how many cuts are made, GPR20_POWER_CUT_SEED repeats those of a run.
"""

from __future__ import annotations

import importlib.util
import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parents[1]
CUTS = int(os.environ.get("GPR20_POWER_CUTS", "20"))
SEED = os.environ.get("GPR20_POWER_CUT_SEED") or str(random.SystemRandom().randrange(10**9))
CONTROL_CUTS = 3
NOT_POSSIBLE = 77


def cut(place, cuts, *options):
    """Cut the power and return what the program found."""
    if importlib.util.find_spec("rosbag") is None:
        pytest.skip("the stock repair of a bag is part of ROS")
    ended = subprocess.run(
        [sys.executable, str(HERE / "power_cut_storage.py"), str(place), str(cuts), SEED, *options],
        capture_output=True,
        text=True,
        timeout=60 + 5 * cuts,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), *sys.path])},
    )
    if ended.returncode == NOT_POSSIBLE:
        pytest.skip(f"no power cuts here: {ended.stdout.strip()}")
    assert ended.returncode == 0, ended.stdout + ended.stderr
    print(f"repeat with GPR20_POWER_CUT_SEED={SEED}: {ended.stdout}")
    return json.loads(ended.stdout)


def test_power_cuts_lose_nothing_acknowledged_and_every_survey_can_be_finished(tmp_path):
    found = cut(tmp_path, CUTS)
    assert found["faults"] == []
    assert found["cuts"] >= CUTS


def test_without_fsync_power_cuts_lose_acknowledged_traces(tmp_path):
    assert cut(tmp_path, CONTROL_CUTS, "--without-fsync")["losses"] > 0
