"""The analysis runs as a process of its own, at low priority, and can be cancelled."""

import queue
import stat
import sys
from pathlib import Path

import pytest

from gpr20_user_interface.low.analysis_program import AnalysisProgram
from gpr20_user_interface.mid.candidate_list import candidates_from

pytestmark = pytest.mark.takes(20)
SAMPLE = "catkin_ws/src/gpr20_analysis/src/gpr20_analysis/sample/survey.mcap"
ROOT = Path(__file__).resolve().parents[5]
LIMIT_S = 60.0
# At the lowest priority, beside other work.
SLOW_LIMIT_S = 400.0
PRIORITY = """
import os, sys
print(os.nice(0), sys.argv[1:], 'ñ')
print('remark', file=sys.stderr)
sys.exit(1)
"""
ENDLESS = """
import os, signal
print(os.getpid(), flush=True)
signal.pause()
"""


def program(tmp_path, source):
    path = tmp_path / "gpr20"
    path.write_text(f"#!{sys.executable}\n{source}", encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    ended = queue.Queue()
    return AnalysisProgram(ended.put, lambda: str(path)), ended


def test_it_runs_at_low_priority_and_gives_back_everything(tmp_path):
    analysis, ended = program(tmp_path, PRIORITY)
    number = analysis.start(["candidates", "a folder"])
    event = ended.get(timeout=LIMIT_S)
    assert (event.number, event.status, event.errors) == (number, 1, "remark\n")
    assert event.output == "19 ['candidates', 'a folder'] ñ\n"


def test_it_ends_when_it_is_cancelled_and_its_end_has_its_number(tmp_path):
    analysis, ended = program(tmp_path, ENDLESS)
    first = analysis.start([])
    second = analysis.start([])
    assert ended.get(timeout=LIMIT_S).number == first
    analysis.cancel()
    event = ended.get(timeout=LIMIT_S)
    assert event.number == second and event.status != 0
    analysis.cancel()


def test_a_program_that_is_not_there_is_not_installed():
    assert not AnalysisProgram(lambda _: None, lambda: None).is_installed()


def test_the_window_reads_what_the_real_command_prints():
    pytest.importorskip("xarray")
    ended = queue.Queue()
    analysis = AnalysisProgram(ended.put)
    if not analysis.is_installed():
        pytest.skip("the analysis is not installed for this Python")
    analysis.start(["candidates", str(ROOT / SAMPLE), "--json", "--permittivity=5"])
    event = ended.get(timeout=SLOW_LIMIT_S)
    assert event.status == 0, event.errors
    survey_id = event.output.split('"survey_id": "')[1].split('"')[0]
    found = candidates_from(event.output, survey_id)
    assert found.simulated and found.candidates
