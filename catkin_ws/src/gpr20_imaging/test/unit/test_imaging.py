"""Images, candidates, maps and exports by a child that may die, hang and refuse."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fault_kit import raises_fault
from imaging_kit import REFUSAL, store_survey
from pytest import approx

import gpr20_analysis
from gpr20_analysis import faults as analysis_faults
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, BUSY, DISK_FULL, NOT_ALLOWED
from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError
from gpr20_imaging.low import analysis_process, child_process
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.child_process import LOWEST_NICE, OOM_SCORE, memory_limit_bytes
from gpr20_imaging.mid.imaging import Imaging
from gpr20_imaging.mid.imaging_parameters import ImagingParameters
from gpr20_imaging.mid.job_queue import MOST_WAITING, JobQueue
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.results.candidates import list_from
from gpr20_survey.results.hidden_target import Targets

LOWERED = child_process.PREFIX
LIMIT_S = 100.0


@pytest.fixture(scope="module", autouse=True)
def usual_priority():
    """With the lowest one a child waits for as long as the computer is busy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(child_process, "PREFIX", LOWERED[2:])
        yield


@pytest.fixture
def imaging(tmp_path, analysis, sticks):
    made = Imaging(tmp_path / "data", analysis.process, sticks.volumes, lambda *_: None)
    yield made
    made.close()


@pytest.fixture
def survey(tmp_path):
    return store_survey(tmp_path / "data")


def wait_for(path):
    deadline = time.monotonic() + LIMIT_S
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return int(path.read_text())


def is_running(process):
    status = Path(f"/proc/{process}/stat")
    return status.exists() and status.read_text().rsplit(")", 1)[1].split()[0] != "Z"


def test_one_child_makes_all_images_of_a_survey(imaging, survey, analysis):
    first = imaging.focus("a", survey.name, 4.0)
    survey_id = read_description(survey)["survey_id"]
    second = imaging.focus("b", survey_id, 0.0)
    assert first.levels_db.tolist() == [[[0.0, 1.0], [2.0, 3.0]], [[4.0, 5.0], [6.0, 7.0]]]
    assert first.found.candidates[0].id == "C01"
    # The fake analysis answers with its process as number of traces.
    assert first.traces == second.traces
    assert analysis.asked.read_text() == f"{survey} 4.0\n{survey} None\n"


def test_the_child_has_the_lowest_priority_and_bounded_memory(imaging, survey, monkeypatch):
    monkeypatch.setattr(child_process, "PREFIX", LOWERED)
    child = imaging.focus("a", survey.name, 4.0).traces
    assert os.getpriority(os.PRIO_PROCESS, child) == LOWEST_NICE
    assert Path(f"/proc/{child}/oom_score_adj").read_text().strip() == str(OOM_SCORE)
    limits = Path(f"/proc/{child}/limits").read_text()
    assert f"Max data size             {memory_limit_bytes()}" in limits
    assert os.getpriority(os.PRIO_PROCESS, 0) < LOWEST_NICE


def test_a_child_that_died_or_was_killed_between_requests_is_replaced(imaging, survey, analysis):
    analysis.mode = "die"
    with raises_fault(faults.OTHER_COMPUTER, "Killed by a test"):
        imaging.focus("a", survey.name, 4.0)
    analysis.mode = ""
    first = imaging.focus("a", survey.name, 4.0).traces
    os.kill(first, signal.SIGKILL)
    # The end of all its threads; the node collects it.
    os.waitid(os.P_PID, first, os.WEXITED | os.WNOWAIT)
    assert imaging.focus("b", survey.name, 4.0).traces != first


def test_a_child_that_takes_too_long_is_ended(imaging, survey, analysis, monkeypatch):
    imaging.focus("a", survey.name, 4.0)  # The child has started: that takes long under load.
    analysis.mode = "hang"
    monkeypatch.setattr(analysis_process, "FOCUS_LIMIT_S", 3.0)
    with raises_fault(faults.OTHER_COMPUTER, 3):
        imaging.focus("a", survey.name, 4.0)
    assert not is_running(wait_for(analysis.started))


def test_a_refusal_of_the_analysis_keeps_its_fault_and_template(imaging, survey, analysis):
    analysis.mode = "full"
    with raises_fault(DISK_FULL, "/tmp/x"):
        imaging.focus("a", survey.name, 4.0)
    analysis.mode = "refuse"
    with raises_fault("test.refused") as caught:
        imaging.focus("a", survey.name, 4.0)
    message = caught.value.message
    assert message == REFUSAL and message.cause == REFUSAL.fault


def test_impossible_permittivities_and_surveys_elsewhere_are_refused(imaging, survey):
    kinds = ["survey-zip"]
    for wrong in (-1.0, 0.5, 101.0, math.nan, math.inf):
        for ask in (
            lambda one=wrong: imaging.focus("a", survey.name, one),
            lambda one=wrong: imaging.export("a", survey.name, kinds, one, "en", "/media/x"),
        ):
            with raises_fault(NOT_ALLOWED, f"{wrong:g}", "100"):
                ask()
    for name in ("", "..", "/etc", "20260921T141320_00000000"):
        with pytest.raises(Gpr20Error):
            imaging.focus("a", name, 4.0)


def test_without_the_analysis_the_node_says_what_is_missing(tmp_path, sticks, survey, monkeypatch):
    # Every workspace has the analysis, also where its libraries are not installed.
    monkeypatch.setattr(analysis_process, "NEEDED", ("json", "no_such_library"))
    imaging = Imaging(tmp_path / "data", AnalysisProcess(), sticks.volumes, lambda *_: None)
    assert imaging.missing.fault == faults.OTHER_COMPUTER
    with raises_fault(faults.OTHER_COMPUTER, imaging.computer):
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
    asking.join(LIMIT_S)
    assert len(failures) == 1
    assert not is_running(child)
    with raises_fault(ASKED_FOR):
        imaging.cancel("slow")


def test_requests_are_carried_out_one_at_a_time_are_bounded_and_can_be_cancelled():
    jobs = JobQueue(lambda: None, lambda: None, 60.0)
    go, running, most = threading.Event(), [], []

    def work(_cancellation):
        running.append(1)
        most.append(len(running))
        go.wait(LIMIT_S)
        running.pop()

    cancelled = []

    def ask(name):
        try:
            jobs.run(name, work)
        except CancelledError:
            cancelled.append(name)

    names = ["x"] * (MOST_WAITING - 1) + ["last"]
    threads = [threading.Thread(target=ask, args=(name,)) for name in names]
    for number, one in enumerate(threads, 1):
        one.start()
        while jobs.waiting < number:
            time.sleep(0.01)
    with raises_fault(BUSY):
        jobs.run("y", work)
    assert jobs.cancel("last")
    go.set()
    for one in threads:
        one.join()
    jobs.close()
    assert max(most) == 1 and len(most) == MOST_WAITING - 1 and cancelled == ["last"]


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
    deadline = time.monotonic() + LIMIT_S
    while is_running(child):
        assert time.monotonic() < deadline
        time.sleep(0.01)


PERMITTIVITY = 5.0


@pytest.fixture(scope="module")
def process():
    made = AnalysisProcess()
    yield made
    made.close()


def corner_of(count, path):
    """Write a corner of the sample survey, and return it."""
    few = {"x": slice(count), "y": slice(count), "frequency": slice(None, None, 2)}
    corner = gpr20_analysis.load_survey(sample_survey()).isel(few)
    gpr20_analysis.write_dataset(corner, path)
    return corner


@pytest.mark.timeout(300)
def test_candidates_are_those_of_the_analysis(process, tmp_path):
    survey = tmp_path / "corner.nc"
    corner = corner_of(7, survey)
    listed = tmp_path / "list.json"
    process.write("candidates", survey, listed, PERMITTIVITY, "en", Cancellation())
    found = list_from(listed.read_text(encoding="utf-8"))
    cleaned = gpr20_analysis.process_survey(corner, "background:method=surface")
    image = gpr20_analysis.image_survey(
        cleaned, gpr20_analysis.ImageOptions(permittivity=PERMITTIVITY)
    )
    here = gpr20_analysis.find_candidates(image)
    # Sums of several threads differ in their last bits.
    assert [one.id for one in found.candidates] == [one.id for one in here.candidates]
    for one, same in zip(found.candidates, here.candidates):
        assert (one.x_m, one.y_m, one.depth_m) == approx(
            (same.x_m, same.y_m, same.depth_m), abs=1e-6
        )


@pytest.mark.timeout(300)
def test_where_a_mine_could_hide_is_that_of_the_analysis(process, tmp_path):
    file = tmp_path / "corner.nc"
    corner = corner_of(4, file)
    found = process.map_hidden(file, PERMITTIVITY, "pmn", Cancellation())
    here = gpr20_analysis.map_hidden_in_field(corner, PERMITTIVITY, Targets.PMN.value)
    assert found.target == Targets.PMN.value and found.tried.sum() > 0
    assert (found.tried == here.tried).all() and (found.found == here.found).all()
    with raises_fault(NOT_ALLOWED, "tank"):
        process.map_hidden(file, PERMITTIVITY, "tank", Cancellation())


def test_a_reason_comes_with_its_fault(process, tmp_path):
    with raises_fault(analysis_faults.INPUT, tmp_path / "nowhere"):
        output = tmp_path / "list.csv"
        process.write("candidates", tmp_path / "nowhere", output, None, "en", Cancellation())
    with raises_fault(analysis_faults.INPUT):
        folder = tmp_path / "20260921T141320_0f8fad5b"
        (folder / "traces").mkdir(parents=True)
        (folder / "log.jsonl").write_text("{}")
        process.focus(folder, np.float64(4.0), Cancellation())


def test_the_nodes_answers_are_those_of_the_imaging(
    tmp_path, analysis, sticks, survey, monkeypatch
):
    rospy = pytest.importorskip("rospy")
    node_module = pytest.importorskip("gpr20_imaging.high.imaging_node")
    requests = pytest.importorskip("gpr20_msgs.srv")
    services, published = {}, {}

    def publisher(name, *_, **__):
        return SimpleNamespace(publish=lambda message: published.setdefault(name, message))

    for place, name, value in (
        (rospy, "Publisher", publisher),
        (rospy, "on_shutdown", lambda _stop: None),
        (rospy.Time, "now", staticmethod(lambda: rospy.Time(7))),
        (node_module, "AnalysisProcess", lambda: analysis.process),
        (node_module, "Diagnostics", lambda _name, health: health),
        (node_module, "publish_description", lambda *_: None),
        (node_module, "advertise", lambda name, _kind, do: services.setdefault(name, do)),
        (node_module, "ExportNotes", lambda: SimpleNamespace(add=lambda *_: REFUSAL)),
    ):
        monkeypatch.setattr(place, name, value)
    node = node_module.ImagingNode(ImagingParameters(str(tmp_path / "data")), sticks.volumes)
    asked = {"request_id": "a", "survey": survey.name, "permittivity": 4.0}
    focused = services["focus_survey"](requests.FocusSurveyRequest(**asked))
    assert focused.success and len(focused.levels_db) == 8 * 4
    assert list_from(published["candidates"]).candidates[0].id == "C01"
    stick = sticks.plug_in()
    (listed,) = services["list_volumes"](requests.ListVolumesRequest()).volumes
    assert (listed.path, listed.writable) == (str(stick), True)
    wanted = {**asked, "kinds": ["survey-zip"], "language": "en"}
    on_stick = requests.ExportSurveyRequest(**wanted, volume=str(stick))
    exported = services["export_survey"](on_stick)
    # The log of the survey does not say so, and why.
    assert len(exported.files) == 1 and exported.fault.code == REFUSAL.fault_code
    assert published["imaging_progress"].request_id == "a"
    with raises_fault(ASKED_FOR):
        services["cancel_imaging"](requests.CancelImagingRequest(request_id="a"))
    assert node._diagnostics()[0] == node_module.OK
    node._imaging.close()
