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

from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError
from gpr20_imaging.low.analysis_command import AnalysisCommand
from gpr20_imaging.low.child_process import LOWEST_NICE, OOM_SCORE, memory_limit_bytes
from gpr20_imaging.mid.imaging import Imaging
from gpr20_imaging.mid.job_queue import MOST_WAITING, JobQueue


@pytest.fixture
def imaging(tmp_path, command, sticks):
    made = Imaging(tmp_path / "data", command.command, sticks.volumes, lambda *_: None)
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


def test_one_child_makes_all_images_of_a_survey(imaging, survey, command):
    first = imaging.focus("a", survey.name, 4.0)
    second = imaging.focus("b", first.survey_id, 0.0)
    assert first.levels_db.tobytes() == bytes(range(4)) * 8
    assert (first.levels_db.shape, first.found.candidates[0].id) == ((2, 2, 2), "C01")
    # The fake command answers with its process as number of traces.
    assert first.traces == second.traces
    asked = [json.loads(one) for one in command.asked.read_text().splitlines()]
    assert [one["permittivity"] for one in asked] == [4.0, None]
    assert asked[0]["survey"] == str(survey)
    assert not any(Path(one["levels"]).exists() for one in asked)


def test_the_child_has_the_lowest_priority_and_bounded_memory(imaging, survey):
    child = imaging.focus("a", survey.name, 4.0).traces
    assert os.getpriority(os.PRIO_PROCESS, child) == LOWEST_NICE
    assert Path(f"/proc/{child}/oom_score_adj").read_text().strip() == str(OOM_SCORE)
    limits = Path(f"/proc/{child}/limits").read_text()
    assert f"Max data size             {memory_limit_bytes()}" in limits
    assert os.getpriority(os.PRIO_PROCESS, 0) < LOWEST_NICE


def test_a_child_that_died_is_replaced(imaging, survey, command):
    command.mode = "die"
    with raises_fault(faults.TOO_MUCH, "Killed by a test"):
        imaging.focus("a", survey.name, 4.0)
    command.mode = ""
    assert imaging.focus("b", survey.name, 4.0).traces


def test_a_refusal_of_the_analysis_keeps_its_fault_and_template(imaging, survey, command):
    command.mode = "error"
    with raises_fault("test.refused") as caught:
        imaging.focus("a", survey.name, 4.0)
    message = caught.value.message
    assert message == REFUSAL and message.cause == REFUSAL.fault


def test_candidates_come_with_the_remarks_of_the_command(imaging, survey):
    found = imaging.find_candidates("a", survey.name, 0.0, "es")
    assert [str(note) for note in found.found.notes] == [
        *("candidates", str(survey), "--json", "--leave-out-missing", "--language", "es")
    ]
    assert found.remarks == "note: a remark"


def test_an_answer_of_the_analysis_that_is_not_valid_is_a_failure(imaging, survey, command):
    command.mode = "damage"
    for ask in (
        lambda: imaging.focus("a", survey.name, 4.0),
        lambda: imaging.find_candidates("a", survey.name, 0.0, "en"),
    ):
        with pytest.raises(InvalidValueError, match="not complete or not valid"):
            ask()


def test_without_a_list_the_reason_is_that_of_the_command(imaging, survey, command):
    command.mode = "refuse"
    with raises_fault("test.refused") as caught:
        imaging.find_candidates("a", survey.name, 0.0, "en")
    assert caught.value.message == REFUSAL


def test_what_a_command_printed_as_it_crashed_is_the_reason(imaging, survey, command):
    command.mode = "crash"
    with raises_fault(faults.FAILED, "Killed by a test"):
        imaging.find_candidates("a", survey.name, 0.0, "en")


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


def test_without_the_analysis_the_node_says_what_is_missing(tmp_path, sticks, survey):
    imaging = Imaging(
        tmp_path / "data", AnalysisCommand(lambda: None), sticks.volumes, lambda *_: None
    )
    assert imaging.missing.fault == faults.NOT_INSTALLED
    with raises_fault(faults.NOT_INSTALLED, imaging.computer):
        imaging.focus("a", survey.name, 4.0)
    # The data themselves need no analysis.
    stick = sticks.plug_in()
    assert imaging.export("b", survey.name, ["survey-zip"], 0.0, "en", str(stick))
    imaging.close()


def test_a_request_that_runs_can_be_cancelled(imaging, survey, command):
    command.mode = "hang"
    failures = []

    def ask():
        try:
            imaging.focus("slow", survey.name, 4.0)
        except CancelledError as error:
            failures.append(error)

    asking = threading.Thread(target=ask)
    asking.start()
    child = wait_for(command.started)
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
from gpr20_imaging.low.analysis_command import AnalysisCommand
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.imaging import Imaging
command, data, survey = sys.argv[1:]
imaging = Imaging(Path(data), AnalysisCommand(lambda: command), UsbVolumes(), lambda *_: None)
imaging.focus("a", survey, 4.0)
"""


def test_the_child_is_killed_with_the_node(tmp_path, command, survey):
    command.mode = "hang"
    arguments = [command.command.path, str(survey.parent), survey.name]
    node = subprocess.Popen([sys.executable, "-c", NODE, *arguments])
    child = wait_for(command.started)
    node.send_signal(signal.SIGKILL)
    node.wait()
    deadline = time.monotonic() + 20.0
    while is_running(child):
        assert time.monotonic() < deadline
        time.sleep(0.01)
