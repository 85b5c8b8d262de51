"""Images, candidates, maps and exports by a worker that may die, hang and refuse."""

import os
import signal
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest
from fault_kit import raises_fault
from imaging_kit import REFUSAL, image_here, store_survey
from wait_kit import wait_until

import gpr20_analysis
from gpr20_analysis import errors as analysis_faults
from gpr20_analysis.sample import sample_survey
from gpr20_common.faults import ASKED_FOR, BUSY, DISK_FULL, NOT_ALLOWED
from gpr20_imaging import faults
from gpr20_imaging.faults import ImagingError
from gpr20_imaging.low import worker_process
from gpr20_imaging.low.worker_process import OOM_SCORE, WorkerProcess, memory_limit_bytes
from gpr20_imaging.mid import imaging as imaging_module
from gpr20_imaging.mid.exporting import FOLDER
from gpr20_imaging.mid.imaging import MOST_KEPT, MOST_WAITING, Imaging
from gpr20_survey.folder.log_record import Kind, soil_values
from gpr20_survey.folder.recovery import Fact, add_to_survey, read_description
from gpr20_survey.results.hiding_map import Targets

LOWERED, LOWEST_NICE = worker_process.PREFIX, 19
LIMIT_S = 100.0
NOW = "2026-10-01T10:00:00.000000+00:00"


@pytest.fixture(scope="module", autouse=True)
def usual_priority():
    """With the lowest one a child waits for as long as the computer is busy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker_process, "PREFIX", LOWERED[2:])
        yield


@pytest.fixture
def imaging(tmp_path, worker, sticks):
    made = Imaging(tmp_path / "data", worker, lambda *_: None)
    yield made
    made.close()


@pytest.fixture
def survey(tmp_path):
    return store_survey(tmp_path / "data")


def wait_for(path):
    wait_until(lambda: path.exists() and path.read_text())
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
    monkeypatch.setattr(worker_process, "PREFIX", LOWERED)
    own = os.getpriority(os.PRIO_PROCESS, 0)
    child = imaging.focus("a", survey.name, 4.0).traces
    assert os.getpriority(os.PRIO_PROCESS, child) == LOWEST_NICE
    assert Path(f"/proc/{child}/oom_score_adj").read_text().strip() == str(OOM_SCORE)
    limits = Path(f"/proc/{child}/limits").read_text()
    assert f"Max data size             {memory_limit_bytes()}" in limits
    assert os.getpriority(os.PRIO_PROCESS, 0) == own


def test_a_child_that_died_or_was_killed_between_requests_is_replaced(imaging, survey, analysis):
    analysis.mode = "die"
    with raises_fault(faults.OTHER_COMPUTER, "Killed by a test"):
        imaging.focus("a", survey.name, 4.0)
    analysis.mode = ""
    first = imaging.focus("a", survey.name, 4.0).traces
    os.kill(first, signal.SIGKILL)
    # The end of all its threads; the node collects it.
    os.waitid(os.P_PID, first, os.WEXITED | os.WNOWAIT)
    assert imaging.focus("b", survey.name, 5.0).traces != first


def test_a_child_that_takes_too_long_is_ended(imaging, survey, analysis, monkeypatch):
    imaging.focus("a", survey.name, 4.0)  # The child has started: that takes long under load.
    analysis.mode = "hang"
    monkeypatch.setattr(imaging_module, "FOCUS_LIMIT_S", 3.0)
    with raises_fault(faults.OTHER_COMPUTER, 3):
        imaging.focus("a", survey.name, 5.0)
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


def test_without_the_analysis_the_node_says_what_is_missing(
    tmp_path, worker, sticks, survey, monkeypatch
):
    # Every workspace has the analysis, also where its libraries are not installed.
    monkeypatch.setattr(worker_process, "NEEDED", ("json", "no_such_library"))
    imaging = Imaging(tmp_path / "data", worker, lambda *_: None)
    assert imaging.missing.fault == faults.OTHER_COMPUTER
    with raises_fault(faults.OTHER_COMPUTER, imaging.computer):
        imaging.focus("a", survey.name, 4.0)
    # The data themselves need no analysis.
    stick = sticks.plug_in()
    assert imaging.export("b", survey.name, ["survey-zip"], 0.0, "en", str(stick))[0]
    imaging.close()


def add(kind, values):
    record = {"time": NOW, **values}
    return lambda folder: add_to_survey(folder, lambda _description: Fact(kind, record), NOW)


# What happens to a survey, and whether its answer may be another one then.
CHANGES = (
    *((add(kind, {}), False) for kind in (Kind.FOUND, Kind.EXPORT, Kind.AUDIT)),
    *((add(kind, {}), True) for kind in (Kind.CLOCK, Kind.DRIFT, Kind.ANNOTATION)),
    (add(Kind.DECISION, soil_values(7.0, 0)), True),
    (lambda folder: (folder / "traces" / "000003.json").touch(), True),
    (lambda folder: (folder / "traces" / "000000.json").write_bytes(b"9" * 50_000), True),
)


def test_what_anybody_has_found_is_known_until_the_survey_or_its_soil_changes(
    survey, worker, analysis
):
    lists = []
    with closing(Imaging(survey.parent, worker, lambda *_: None, lists.append)) as imaging:

        def focus(permittivity=0.0, only_known=True):
            return imaging.focus("a", survey.name, permittivity, only_known)

        searched = 0
        for change, is_other in ((Path.stat, True), *CHANGES):
            change(survey)
            if is_other:
                with raises_fault(ASKED_FOR):
                    focus()
                first, searched = focus(only_known=False), searched + 1
            assert focus() is first and focus(only_known=False) is first
            assert len(analysis.asked.read_text().splitlines()) == len(lists) == searched
        # With other options it is another answer, beside this one.
        for number in range(1, MOST_KEPT):
            focus(number + 1.0, only_known=False)
        assert focus() is first
        focus(90.0, only_known=False)
        with raises_fault(ASKED_FOR):
            focus()


def asked(ask):
    """Ask in a thread; return it, and what it raises."""
    failures = []

    def run():
        try:
            ask()
        except ImagingError as error:
            failures.append(error.message.fault_code)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, failures


@pytest.mark.parametrize("kind", ["image", "export"])
def test_a_request_that_runs_can_be_cancelled_and_leaves_nothing(
    imaging, survey, analysis, sticks, kind
):
    stick = sticks.plug_in()
    analysis.mode = "hang" if kind == "image" else "hang at the stick"
    kinds = ["survey-zip"]
    thread, failures = asked(
        lambda: (
            imaging.focus("slow", survey.name, 4.0)
            if kind == "image"
            else imaging.export("slow", survey.name, kinds, 4.0, "en", str(stick))
        )
    )
    child = wait_for(analysis.started)
    imaging.cancel("slow")
    thread.join(LIMIT_S)
    assert failures == [ASKED_FOR.code]
    assert not is_running(child)
    assert list((stick / FOLDER).glob("*")) == []
    with raises_fault(ASKED_FOR):
        imaging.cancel("slow")


class SlowWorker:
    has_analysis = True

    def __init__(self):
        self.go, self.running, self.most = threading.Event(), [], []

    def start(self):
        pass

    end = close = start

    def ask(self, *_):
        self.running.append(1)
        self.most.append(len(self.running))
        self.go.wait(LIMIT_S)
        self.running.pop()
        return image_here()


def test_requests_are_carried_out_one_at_a_time_are_bounded_and_can_be_cancelled(
    tmp_path, survey, sticks
):
    worker = SlowWorker()
    imaging = Imaging(tmp_path / "data", worker, lambda *_: None)
    threads = []
    for number in range(MOST_WAITING):
        name = "last" if number == MOST_WAITING - 1 else "x"
        soil = 4.0 + max(1, number)
        threads.append(asked(lambda name=name, soil=soil: imaging.focus(name, survey.name, soil)))
        wait_until(lambda number=number: imaging.requests > number)
    with raises_fault(BUSY):
        imaging.focus("y", survey.name, 4.0)
    imaging.cancel("last")
    worker.go.set()
    for thread, _failures in threads:
        thread.join(LIMIT_S)
    imaging.close()
    # Those who asked for the same at once got one answer.
    assert max(worker.most) == 1 and len(worker.most) == MOST_WAITING - 2
    assert [failures for _thread, failures in threads if failures] == [[ASKED_FOR.code]]


def test_a_worker_that_ends_idle_as_the_request_comes_is_started_again(imaging, survey, analysis):
    analysis.mode = "leave"
    assert imaging.focus("a", survey.name, 4.0).found.candidates[0].id == "C01"


def test_a_worker_that_was_ended_gets_no_further_request(imaging, worker, survey):
    first = imaging.focus("a", survey.name, 4.0).traces
    worker.end()
    assert imaging.focus("b", survey.name, 5.0).traces != first


NODE = """
import sys
from pathlib import Path
from gpr20_imaging.low.worker_process import WorkerProcess
from gpr20_imaging.mid.imaging import Imaging
*command, data, survey = sys.argv[1:]
imaging = Imaging(Path(data), WorkerProcess(command), lambda *_: None)
imaging.focus("a", survey, 4.0)
"""


def test_the_child_is_killed_with_the_node(tmp_path, analysis, survey):
    analysis.mode = "hang"
    arguments = [*analysis.command, str(survey.parent), survey.name]
    node = subprocess.Popen([sys.executable, "-c", NODE, *arguments])
    child = wait_for(analysis.started)
    node.send_signal(signal.SIGKILL)
    node.wait()
    wait_until(lambda: not is_running(child))


PERMITTIVITY = 5.0


@pytest.fixture(scope="module")
def process():
    made = WorkerProcess()
    yield made
    made.close()


def made_by(process, name, *arguments):
    return process.ask(LIMIT_S, lambda _stage: None, name, *arguments)


def test_where_a_mine_could_hide_is_that_of_the_analysis(process, tmp_path):
    file, few = tmp_path / "corner.nc", {"x": slice(4), "y": slice(4)}
    corner = gpr20_analysis.load_survey(sample_survey()).isel(
        {**few, "frequency": slice(0, None, 2)}
    )
    gpr20_analysis.write_dataset(corner, file)
    found = made_by(process, "map_hidden", file, PERMITTIVITY, "pmn")
    detector = gpr20_analysis.Detector(gpr20_analysis.field_options(PERMITTIVITY, corner))
    here = gpr20_analysis.map_hidden(corner, detector, Targets.PMN.value)
    assert found.target == Targets.PMN.value and found.tried.sum() > 0
    assert (found.tried == here.tried).all() and (found.found == here.found).all()
    # A reason comes with its fault.
    with raises_fault(NOT_ALLOWED, "tank"):
        made_by(process, "map_hidden", file, PERMITTIVITY, "tank")
    with raises_fault(analysis_faults.INPUT, tmp_path / "nowhere"):
        made_by(process, "focus", tmp_path / "nowhere", None)
