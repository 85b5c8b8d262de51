"""What verify says of contradictions, and of a survey that is being written."""

import json
import multiprocessing
import os
import threading

from case_kit import each_case
from log_examples import marker
from survey_kit import (
    NOW_NS,
    POINTS,
    STARTED_US,
    SURVEY,
    make_survey,
    planned_trace,
)

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.read.traces import Sample
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.faults import LOCKED
from gpr20_survey.files.durable_files import locked
from gpr20_survey.folder import recovery
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.trace import utc_time

S, ENDED = 10**6, "2026-09-21T14:00:00.000000+00:00"  # [us]
TIMES = {"started": utc_time.iso_text(STARTED_US), "ended": utc_time.iso_text(NOW_NS // 1000)}


def at(time_us, sweep_us=None):
    sweep_us = time_us - 1000 if sweep_us is None else sweep_us
    return {
        "timestamp_us": time_us,
        "sweep_started_us": sweep_us,
        "sweep_ended_us": max(sweep_us, time_us - 500),
    }


def analyzer(serial):
    return {"instrument": {"identity": f"Anritsu,MS2026C/2,{serial},1.0"}}


def nodes(*simulated):
    return {"nodes": [{"name": "/x", "simulated": one, "hardware": "pins"} for one in simulated]}


@each_case(
    "number, simulated, measured_by, named",
    [
        (0, True, analyzer("SIMULATED"), ""),
        (1, False, {"instrument": {}}, ""),
        (2, False, nodes(False), ""),
        (3, False, analyzer("SIMULATED"), "SIMULATED"),
        (4, True, analyzer("7654321"), "7654321"),
        (5, False, nodes(False, True), "node /x"),
    ],
)
def test_simulated_agrees_with_what_measured_the_survey(
    tmp_path, number, simulated, measured_by, named
):
    more = {"simulated": simulated, **measured_by}
    folder = make_survey(tmp_path / str(number), 4, "stopped", more=more)
    found = [str(one) for one in verify_survey(folder).faults]
    assert len(found) == bool(named) and all(named in one for one in found)


@each_case(
    "times, more, said",
    [
        ({}, {}, ()),
        ({}, {"ended": ENDED}, ("end of the survey is before its start",)),
        ({0: at(STARTED_US - S)}, {}, ("traces 0 are older",)),
        ({3: at(NOW_NS // 1000 + S)}, {}, ("traces 3 are older",)),
        ({1: at(STARTED_US + 3 * S, STARTED_US + 4 * S)}, {}, ("traces 1 are older than",)),
        ({i: at(STARTED_US + (50 - i) * S) for i in range(9)}, {}, ("traces 1, 2, 3, 4, 5, ...",)),
        ({1: at(STARTED_US + 50 * S)}, {"resumed": [""]}, ()),
    ],
)
def test_times_that_contradict_each_other_are_doubted(times, more, said):
    traces = (planned_trace(index, **times.get(index, {})) for index in range(max(4, len(times))))
    found = survey_doubts({**TIMES, **more}, [Sample.of(one, 0) for one in traces])
    assert [one.fault_code for one in found] == [errors.CLOCK.code] * bool(said)
    assert all(one in str(found[0]) for one in said)


STORED = 5


def test_a_survey_that_is_being_written_is_said_to_be_so_and_not_annotated(
    tmp_path, capsys, refusals, monkeypatch
):
    monkeypatch.setattr(recovery, "locked", lambda folder, _wait_s: locked(folder))

    def look(processing):
        (folder,) = (tmp_path / "data").iterdir()
        processing.add_fact("", "marker", json.dumps(marker(1).request()))
        assert main(["verify", str(folder)]) == 1
        printed = capsys.readouterr().out
        assert f"BEING WRITTEN by process {os.getpid()}: {STORED} of {len(POINTS)}" in printed
        assert "FAULT" not in printed and "DAMAGED" not in printed
        found = verify_survey(folder)
        assert (found.faults, found.verdict.fault_code) == ([], LOCKED.code)
        before = (folder / "log.jsonl").read_bytes()
        assert main(["annotate", str(folder), "--site", "here"]) == 3
        assert refusals == [LOCKED.code]
        assert main(["annotate", str(folder)]) == 0  # it only reads
        assert (folder / "log.jsonl").read_bytes() == before

    folder = make_survey(tmp_path, STORED, "stopped", at_end=look)
    assert "INCOMPLETE, but intact" in str(verify_survey(folder).verdict)


def test_no_moment_of_a_survey_that_is_being_written_is_a_fault(tmp_path):
    def look(processing):
        (folder,) = (tmp_path / "data").iterdir()
        written = threading.Thread(target=write, args=(processing,))
        written.start()
        looks = 0
        while written.is_alive() or looks < 2:
            found = verify_survey(folder)
            assert found.faults == [] and found.status == 1
            looks += 1
        written.join()

    def write(processing):
        for index in range(STORED, len(POINTS)):
            processing.store(planned_trace(index))
            processing.add_fact(SURVEY, "report", f'{{"traces": {index}}}')

    folder = make_survey(tmp_path, STORED, "stopped", at_end=look)
    assert verify_survey(folder).faults == []


def test_two_who_write_at_once_lose_nothing(tmp_path):
    folder = make_survey(tmp_path, STORED, "stopped")
    wanted = {"--name": "one", "--site": "two"}
    writers = [
        multiprocessing.get_context("fork").Process(
            target=main, args=(["annotate", str(folder), option, text],)
        )
        for option, text in wanted.items()
    ]
    for one in writers:
        one.start()
    for one in writers:
        one.join()
    noted = annotation_of(read_description(folder))
    assert (noted.name, noted.site) == (*wanted.values(),)
    kinds = [one.kind for one in recover(folder).found.records]
    assert kinds.count(Kind.ANNOTATION.value) == len(writers)
    found = verify_survey(folder)
    assert (found.faults, found.status) == ([], 1)
