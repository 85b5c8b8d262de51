"""A survey that is being written is neither damaged nor changed by those who look at it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

from survey_kit import POINTS, SURVEY, make_survey, planned_trace

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.verify import main as gpr20_verify
from gpr20_survey.faults import LOCKED
from gpr20_survey.folder import annotating
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import Marker

STORED = 5
MARKER = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", 12.5, 20.0)


def test_a_survey_that_is_being_written_is_said_to_be_so(tmp_path, capsys):
    def look(processing):
        folder = tmp_path / "data" / os.listdir(str(tmp_path / "data"))[0]
        processing.add_marker("", MARKER)
        assert gpr20_verify([str(folder)]) == 1
        printed = capsys.readouterr().out
        assert f"BEING WRITTEN by process {os.getpid()}: {STORED} of {len(POINTS)}" in printed
        assert "FAULT" not in printed and "DAMAGED" not in printed
        found = verify_survey(folder)
        assert (found.faults, found.verdict.fault_code) == ([], LOCKED.code)

    folder = make_survey(tmp_path, STORED, "stopped", at_end=look)
    assert "INCOMPLETE, but intact" in str(verify_survey(folder).verdict)


def test_no_moment_of_a_survey_that_is_being_written_is_a_fault(tmp_path):
    def look(processing):
        folder = tmp_path / "data" / os.listdir(str(tmp_path / "data"))[0]
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
            processing.report(SURVEY, f'{{"traces": {index}}}')

    folder = make_survey(tmp_path, STORED, "stopped", at_end=look)
    assert verify_survey(folder).faults == []


def test_annotating_a_survey_that_is_being_written_is_refused(tmp_path, refusals, monkeypatch):
    monkeypatch.setattr(annotating, "SHORT_WAIT_S", 0.1)

    def look(_processing):
        folder = tmp_path / "data" / os.listdir(str(tmp_path / "data"))[0]
        before = (folder / "log.jsonl").read_bytes()
        assert main(["annotate", str(folder), "--site", "here"]) == 3
        assert refusals[-1:] == [LOCKED.code]
        assert (folder / "log.jsonl").read_bytes() == before
        assert main(["annotate", str(folder)]) == 0  # it only reads

    make_survey(tmp_path, STORED, "stopped", at_end=look)


def test_two_who_write_at_once_lose_nothing(tmp_path):
    folder = make_survey(tmp_path, STORED, "stopped")
    program = "import sys; from gpr20_analysis.commands.main import main; sys.exit(main())"
    wanted = {"--name": "one", "--operator": "two", "--site": "three", "--notes": "four"}
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", program, "annotate", str(folder), option, text],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            stdout=subprocess.DEVNULL,
        )
        for option, text in wanted.items()
    ]
    assert [one.wait(timeout=120) for one in writers] == [0] * len(writers)
    noted = annotation_of(read_description(folder))
    assert (noted.name, noted.operator, noted.site, noted.notes) == (*wanted.values(),)
    kinds = [one.kind for one in recover(folder).found.records]
    assert kinds.count(Kind.ANNOTATION.value) == len(writers)
    found = verify_survey(folder)
    assert (found.faults, found.status) == ([], 1)
