import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from case_kit import each_case
from log_examples import NOW
from survey_kit import (
    PARAMETERS,
    POINTS,
    describe_again,
    make_survey,
    planned_trace,
    write_trace_file,
)
from trace_examples import SURVEY

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.faults import LOG_LOST
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import open_log, recover
from gpr20_survey.folder.survey_folder import LOG_FILES
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep import AnalyzerSettings

NO_SETTINGS = AnalyzerSettings()

FOLDER_MODULES = ("rospy", "rosbag", "genpy", "roslib", "rospkg")


def cut_to(mcap, content, count):
    """Cut an MCAP file so that this number of traces is left."""
    for size in range(len(content), 0, -64):
        mcap.write_bytes(content[:size])
        found = StoredMcap(mcap).messages()
        if sum(one.datatype == trace_message.DATATYPE for one in found) == count:
            return


def texts(messages):
    return [str(one) for one in messages]


def without_manifest_faults(found):
    return [fault for fault in texts(found.faults) if "manifest" not in fault]


def test_only_a_closed_survey_with_every_trace_is_complete(finished, stopped, tmp_path, capsys):
    for folder, status, said in (
        (finished, 0, "complete and intact: all 18 planned traces"),
        (stopped, 1, "INCOMPLETE, but intact: 7 of 18 planned traces"),
        (make_survey(tmp_path / "a", len(POINTS), None), 1, "the survey was not closed"),
        (make_survey(tmp_path / "b", len(POINTS), "interrupted"), 1, "18 of 18"),
    ):
        assert main(["verify", str(folder)]) == status, said
        printed = capsys.readouterr().out
        assert said in printed and ("complete" in printed) == (status == 0), said


def test_a_survey_that_was_cut_off_is_judged_by_what_is_whole(tmp_path, capsys):
    folder = make_survey(tmp_path, 7, None)
    assert main(["verify", str(folder)]) == 1
    assert "7 of 18 planned traces are stored and readable, and the survey was not closed" in (
        capsys.readouterr().out
    )
    mcap = folder / "survey.mcap"
    content = mcap.read_bytes()
    cut_to(mcap, content, 6)
    assert main(["verify", str(folder)]) == 1
    assert "trace 6 is not in survey.mcap yet" in capsys.readouterr().out
    cut_to(mcap, content, 5)
    assert main(["verify", str(folder)]) == 2


def test_damage_is_found_without_the_manifest_too(copied):
    """A manifest that was made again hides nothing that contradicts itself."""
    (copied / "manifest.json").unlink()
    trace = sorted((copied / "traces").iterdir())[4]
    original = trace.read_bytes()
    values = json.loads(original)
    values["s21_imag"][2] = values["s21_imag"][2] + 1e-12
    write_trace_file(trace, values)
    faults = without_manifest_faults(verify_survey(copied))
    assert faults == ["trace 4 has other values in survey.mcap than in its JSON file"]
    trace.write_bytes(original)
    assert without_manifest_faults(verify_survey(copied)) == []


def test_what_is_gone_or_was_added_is_named(copied):
    added, lost = copied / "traces" / "note.txt", sorted((copied / "traces").iterdir())[3]
    added.write_text("hello")
    assert texts(verify_survey(copied).faults) == ["traces/note.txt is not in the manifest"]
    added.unlink()
    lost.unlink()
    named = " ".join(texts(verify_survey(copied).faults))
    for said in (
        *(f"traces/{lost.name}", "trace 3 is in survey.mcap"),
        *("records 18 stored traces, but there are 17", "the log says that the survey is complete"),
    ):
        assert said in named, said


@pytest.mark.parametrize("kind", [Kind.PLAN, Kind.END])
def test_what_nobody_says_of_a_closed_survey_is_a_fault(copied, kind):
    log = open_log(copied, recover(copied), NOW)
    planned = recover(copied).description["parameters"]
    log.add(log.next(kind, {"parameters": {}, "outcome": "finished"}, NOW))
    found = verify_survey(copied)
    assert f"of kind {kind.value}, was added after the survey was closed" in " ".join(
        texts(found.faults)
    )
    assert kind is Kind.END or recover(copied).description["parameters"] == planned


def test_an_entry_that_the_recording_alone_holds_is_named(tmp_path):
    def note(processing):
        processing.add_fact(SURVEY, "annotation", json.dumps(Annotation(operator="Ana").values()))
        processing.store(planned_trace(7))

    folder = make_survey(tmp_path, 7, None, at_end=note)
    for name in LOG_FILES:
        lines = (folder / name).read_bytes().splitlines(keepends=True)
        (folder / name).write_bytes(b"".join(lines[:-1]))
    found = verify_survey(folder)
    assert "entry 1 of the log, of kind annotation, is in survey.mcap alone" in texts(found.notes)
    assert found.unconfirmed and not found.faults


def test_traces_alone_are_counted_and_not_taken_for_real_ground(copied):
    for path in copied.iterdir():
        if path.is_file():
            path.unlink()
    found = verify_survey(copied)
    assert (found.stored, len(found.faults)) == (len(POINTS), 1)
    assert "18 traces are stored and readable" in str(found.verdict)
    assert found.verdict.fault_code == LOG_LOST.code
    (trace, *_others) = (copied / "traces").iterdir()
    trace.write_bytes(trace.read_bytes()[:-9])
    found = verify_survey(copied)
    assert found.stored == len(POINTS) - 1 and f"{trace.name} is not" in str(found.faults[1])
    assert found.verdict.fault_code == LOG_LOST.code
    trace.unlink()
    assert "not known whether the data are SIMULATED" in str(found.notes[0])
    assert "not known whether the data are SIMULATED" in load_survey(copied).attrs["notes"][0]


def test_where_both_logs_are_lost_nobody_is_told_to_resume(copied):
    for name in LOG_FILES:
        content = (copied / name).read_bytes()
        (copied / name).write_bytes(content.replace(b"\n", b"\r\n"))
    verdict = verify_survey(copied).verdict
    assert verdict.fault_code == LOG_LOST.code
    assert "put log.jsonl and log.copy.jsonl back" in str(verdict.remedy)


def test_a_trace_that_is_not_as_planned_is_named(tmp_path):
    short = planned_trace(5).frequency_hz[:4]
    for name, changes, said in (
        ("a", {"x_coord_mm": 10.02}, "trace 5 was measured at x 10.02 instead of 20"),
        (
            "b",
            {"frequency_hz": short, "s21_real": short, "s21_imag": short},
            "trace 5 has 4 frequencies instead of 5",
        ),
    ):
        folder = make_survey(tmp_path / name, 7, "stopped", misplaced={5: changes})
        assert texts(verify_survey(folder).faults) == [said]


OTHERS = {5: {"analyzer": AnalyzerSettings(500.0, 1, "LOW")}, 6: {"analyzer": NO_SETTINGS}}
RECORDED = {"if_bandwidth_hz": 1000.0, "averages": 4, "output_power": "HIGH"}


@each_case(
    "number, recorded, wanted",
    [(0, {}, {"if_bandwidth_hz": 1000.0}), (1, {}, {"output_power": "HIGH"}), (2, RECORDED, {})],
)
def test_a_trace_with_other_settings_of_the_vna_is_named(tmp_path, number, recorded, wanted):
    more = {
        "instrument": {"identity": "MS2026C", "sweep": {"points": 5, **recorded}},
        "parameters": {**PARAMETERS, **wanted},
    }
    folder = make_survey(tmp_path / str(number), 7, "stopped", misplaced=OTHERS, more=more)
    low, unknown = texts(verify_survey(folder).faults)
    assert low.startswith("trace 5 ") and "IF bandwidth 500 Hz, averages 1" in low
    assert unknown.startswith("trace 6 ") and "IF bandwidth unknown, averages unknown" in unknown


def test_settings_of_the_vna_that_are_not_recorded_are_not_compared(tmp_path):
    odd = {"sweep": {"if_bandwidth_hz": "x", "averages": 4.5, "output_power": None}}
    for number, instrument in enumerate((None, odd)):
        place, more = tmp_path / str(number), {"instrument": instrument}
        folder = make_survey(place, 18, "finished", misplaced=OTHERS, more=more)
        assert texts(verify_survey(folder).faults) == [], instrument


CONTRADICTIONS = (
    ({"planned_traces": 7}, "records 7 planned traces, but there are 18"),
    ({"stored_traces": 18}, "records 18 stored traces, but there are 7"),
    ({"outcome": "finished"}, "says that the survey is complete, but"),
    ({"report": {"complete": True}}, "says that the survey is complete, but"),
    ({"axes": {}}, "the plan is unknown: axes/x is missing"),
    ({"parameters": {**PARAMETERS, "x_points": "3"}}, "x_points"),
)


def test_words_that_contradict_the_files_are_faults(stopped, tmp_path):
    folder = Path(shutil.copytree(str(stopped), str(tmp_path / "s")))
    described = {name: (folder / name).read_bytes() for name in LOG_FILES}
    for changes, reason in CONTRADICTIONS:
        for name, content in described.items():
            (folder / name).write_bytes(content)
        describe_again(folder, **changes)
        found = verify_survey(folder)
        assert found.status == 2, changes
        assert any(reason in fault for fault in texts(found.faults)), changes


def test_a_report_that_does_not_claim_more_than_the_files_is_true(stopped, tmp_path):
    folder = Path(shutil.copytree(str(stopped), str(tmp_path / "s")))
    before = without_manifest_faults(verify_survey(folder))
    for report in (
        {"complete": False, "coverage": "m" * 18},
        {"coverage": "m" * 17 + "f"},
        {"verdict": "INCOMPLETE: 7 of 18"},
        None,
        "complete",
    ):
        describe_again(folder, report=report)
        assert without_manifest_faults(verify_survey(folder)) == before, report


def test_programs_get_the_result_as_json_with_codes(finished, stopped, copied, capsys):
    (next((copied / "traces").iterdir())).write_text("{")
    for folder, status, code in (
        (finished, 0, ""),
        (stopped, 1, errors.NOT_COMPLETE.code),
        (copied, 2, errors.NOT_INTACT.code),
    ):
        assert main(["verify", str(folder), "--json"]) == status
        answer = json.loads(capsys.readouterr().out)
        assert (answer["status"], answer["verdict"]["fault"].get("code", "")) == (status, code)
        assert all(one["fault"]["code"] and one["message"] for one in answer["faults"])
        assert bool(answer["faults"]) == (status == 2)
    for none in (copied.parent, copied / "missing"):
        assert main(["verify", str(none), "--json"]) == 3
        answer = json.loads(capsys.readouterr().out)
        assert answer["error"]["fault"]["code"] == errors.INPUT.code


def test_the_command_runs_where_ros_is_not_installed(finished, tmp_path):
    for module in FOLDER_MODULES:
        (tmp_path / f"{module}.py").write_text("raise ImportError('no ROS here')\n")
    answer = subprocess.run(
        [sys.executable, "-m", "gpr20_analysis.commands.main", "verify", str(finished)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (answer.returncode, answer.stderr) == (0, "")
    assert answer.stdout.startswith("note: not signed\ncomplete and intact")
