import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from fault_kit import raises_fault
from imaging_kit import REFUSAL, store_survey

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import DISK_FULL, NOT_ALLOWED
from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError
from gpr20_imaging.low import analysis_process
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.child_process import LOWEST_NICE, OOM_SCORE, memory_limit_bytes
from gpr20_imaging.mid.imaging import Imaging
from gpr20_imaging.mid.job_queue import MOST_WAITING, JobQueue


@pytest.fixture
def imaging(tmp_path, analysis, sticks):
    made = Imaging(tmp_path / "data", analysis.process, sticks.volumes, lambda *_: None)
    yield made
    made.close()


@pytest.fixture
def survey(tmp_path):
    return store_survey(tmp_path / "data")


def wait_for(path):
    deadline = time.monotonic() + 20.0
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return int(path.read_text())


def is_running(process):
    status = Path(f"/proc/{process}/stat")
    return status.exists() and status.read_text().rsplit(")", 1)[1].split()[0] != "Z"


def test_one_child_makes_all_images_of_a_survey(imaging, survey, analysis):
    first = imaging.focus("a", survey.name, 4.0)
    survey_id = json.loads((survey / "survey.json").read_text())["survey_id"]
    second = imaging.focus("b", survey_id, 0.0)
    assert first.levels_db.tolist() == [[[0.0, 1.0], [2.0, 3.0]], [[4.0, 5.0], [6.0, 7.0]]]
    assert first.found.candidates[0].id == "C01"
    # The fake analysis answers with its process as number of traces.
    assert first.traces == second.traces
    assert analysis.asked.read_text() == f"{survey} 4.0\n{survey} None\n"


def test_the_child_has_the_lowest_priority_and_bounded_memory(imaging, survey):
    child = imaging.focus("a", survey.name, 4.0).traces
    assert os.getpriority(os.PRIO_PROCESS, child) == LOWEST_NICE
    assert Path(f"/proc/{child}/oom_score_adj").read_text().strip() == str(OOM_SCORE)
    limits = Path(f"/proc/{child}/limits").read_text()
    assert f"Max data size             {memory_limit_bytes()}" in limits
    assert os.getpriority(os.PRIO_PROCESS, 0) < LOWEST_NICE


def test_a_child_that_died_is_replaced(imaging, survey, analysis):
    analysis.mode = "die"
    with raises_fault(faults.TOO_MUCH, "Killed by a test"):
        imaging.focus("a", survey.name, 4.0)
    analysis.mode = ""
    assert imaging.focus("b", survey.name, 4.0).traces


def test_a_child_that_was_killed_between_requests_is_replaced(imaging, survey):
    first = imaging.focus("a", survey.name, 4.0).traces
    os.kill(first, signal.SIGKILL)
    # The end of all its threads; the node collects it.
    os.waitid(os.P_PID, first, os.WEXITED | os.WNOWAIT)
    assert imaging.focus("b", survey.name, 4.0).traces != first


def test_a_child_that_takes_too_long_is_ended(imaging, survey, analysis, monkeypatch):
    imaging.focus("a", survey.name, 4.0)  # The child has started: that takes long under load.
    analysis.mode = "hang"
    monkeypatch.setattr(analysis_process, "FOCUS_LIMIT_S", 3.0)
    with raises_fault(faults.TOO_MUCH, 3):
        imaging.focus("a", survey.name, 4.0)
    assert not is_running(wait_for(analysis.started))


def test_a_refusal_of_the_analysis_keeps_its_fault_and_template(imaging, survey, analysis):
    analysis.mode = "refuse"
    for ask in (
        lambda: imaging.focus("a", survey.name, 4.0),
        lambda: imaging.find_candidates("a", survey.name, 0.0, "en"),
    ):
        with raises_fault("test.refused") as caught:
            ask()
        message = caught.value.message
        assert message == REFUSAL and message.cause == REFUSAL.fault


def test_an_error_that_no_package_raises_on_purpose_is_told_too(imaging, survey, analysis):
    analysis.mode = "full"
    with raises_fault(DISK_FULL, "/tmp/x"):
        imaging.focus("a", survey.name, 4.0)


def test_candidates_come_with_remarks_in_the_language(imaging, survey):
    found = imaging.find_candidates("a", survey.name, 0.0, "es")
    assert found.found.candidates[0].id == "C01"
    assert found.remarks == f"{survey} None es"


@pytest.mark.parametrize("permittivity", [-1.0, 0.5, 101.0, math.nan, math.inf])
def test_impossible_permittivities_are_refused(imaging, survey, permittivity):
    for ask in (
        lambda: imaging.focus("a", survey.name, permittivity),
        lambda: imaging.find_candidates("a", survey.name, permittivity, "en"),
        lambda: imaging.export("a", survey.name, ["survey-zip"], permittivity, "en", "/media/x"),
    ):
        with raises_fault(NOT_ALLOWED, f"{permittivity:g}", "100"):
            ask()


@pytest.mark.parametrize("name", ["", "..", "/etc", "20260921T141320_00000000"])
def test_only_surveys_of_the_data_folder_are_read(imaging, name):
    with pytest.raises(Gpr20Error):
        imaging.focus("a", name, 4.0)


def test_without_the_analysis_the_node_says_what_is_missing(tmp_path, sticks, survey, monkeypatch):
    # Every workspace has the analysis, also where its libraries are not installed.
    monkeypatch.setattr(analysis_process, "NEEDED", ("json", "no_such_library"))
    imaging = Imaging(tmp_path / "data", AnalysisProcess(), sticks.volumes, lambda *_: None)
    assert imaging.missing.fault == faults.NOT_INSTALLED
    with raises_fault(faults.NOT_INSTALLED, imaging.computer):
        imaging.focus("a", survey.name, 4.0)
    # The data themselves need no analysis.
    stick = sticks.plug_in()
    assert imaging.export("b", survey.name, ["survey-zip"], 0.0, "en", str(stick))[0]
    imaging.close()


def test_a_request_that_runs_can_be_cancelled(imaging, survey, analysis):
    analysis.mode = "hang"
    failures = []

    def ask():
        try:
            imaging.focus("slow", survey.name, 4.0)
        except CancelledError as error:
            failures.append(error)

    asking = threading.Thread(target=ask)
    asking.start()
    child = wait_for(analysis.started)
    imaging.cancel("slow")
    asking.join(20.0)
    assert len(failures) == 1
    assert not is_running(child)
    with raises_fault(faults.NO_REQUEST):
        imaging.cancel("slow")


def test_requests_are_carried_out_one_at_a_time_and_are_bounded():
    jobs = JobQueue(lambda: None, lambda: None, 60.0)
    go, running, most = threading.Event(), [], []

    def work(_cancellation):
        running.append(1)
        most.append(len(running))
        go.wait(20.0)
        running.pop()

    threads = [threading.Thread(target=lambda: jobs.run("x", work)) for _ in range(MOST_WAITING)]
    for one in threads:
        one.start()
    while jobs.waiting < MOST_WAITING:
        time.sleep(0.01)
    with raises_fault(faults.BUSY):
        jobs.run("y", work)
    go.set()
    for one in threads:
        one.join()
    jobs.close()
    assert max(most) == 1 and len(most) == MOST_WAITING


def test_a_waiting_request_can_be_cancelled():
    jobs = JobQueue(lambda: None, lambda: None, 60.0)
    go, failures = threading.Event(), []
    first = threading.Thread(target=lambda: jobs.run("first", lambda _: go.wait(20.0)))
    first.start()

    def second():
        try:
            jobs.run("second", lambda _: failures.append("ran"))
        except CancelledError:
            failures.append("cancelled")

    waiting = threading.Thread(target=second)
    waiting.start()
    while jobs.waiting < 2:
        time.sleep(0.01)
    assert jobs.cancel("second")
    go.set()
    waiting.join()
    first.join()
    jobs.close()
    assert failures == ["cancelled"]


NODE = """
import sys
from pathlib import Path
from gpr20_imaging.low import analysis_process
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.imaging import Imaging
python, program, data, survey = sys.argv[1:]
analysis = AnalysisProcess([python, program])
imaging = Imaging(Path(data), analysis, UsbVolumes(), lambda *_: None)
imaging.focus("a", survey, 4.0)
"""


def test_the_child_is_killed_with_the_node(tmp_path, analysis, survey):
    analysis.mode = "hang"
    arguments = [*analysis.command, str(survey.parent), survey.name]
    node = subprocess.Popen([sys.executable, "-c", NODE, *arguments])
    child = wait_for(analysis.started)
    node.send_signal(signal.SIGKILL)
    node.wait()
    deadline = time.monotonic() + 20.0
    while is_running(child):
        assert time.monotonic() < deadline
        time.sleep(0.01)
