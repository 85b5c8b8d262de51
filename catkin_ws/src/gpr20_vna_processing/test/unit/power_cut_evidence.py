"""What a survey holds after a power cut, beside what was acknowledged before."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import rosbag
from power_cut_child import ENDED, TRACES
from reopening_kit import assert_whole
from storage_kit import Kit
from test_mcap_file import read_forward, traces_of
from trace_examples import SURVEY, assert_same_numbers

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.recording.recordings import open_recordings


class Acknowledged:
    """What was acknowledged before the power was cut."""

    def __init__(self):
        self.indices = set()
        self.done = set()
        self.phase = ""
        self.too_late = []
        self.at_the_cut = 0

    def note(self, messages, cut_s):
        """Take the messages of a child.

        Args:
            messages: Kind, value, and when the call began that it answers, and ended [s].
            cut_s: When the cut began and ended [s].
        """
        for kind, value, begun_s, ended_s in messages:
            if begun_s > cut_s[1] and kind != "phase":
                self.too_late.append((kind, value))
            elif ended_s > cut_s[0]:
                # Without power nobody is left to answer. Here the kernel may report the success of
                # an fsync in the middle of which the journal was aborted.
                self.at_the_cut += kind != "phase"
            elif kind == "phase":
                self.phase = value
            elif kind == "stored":
                self.indices.add(value)
            else:
                self.done.add(value)
        if ENDED in self.done:
            self.phase = ENDED


def json_traces(folder):
    return [json.loads(path.read_text("ascii")) for path in folder.glob("traces/*.json")]


def bag_traces(folder):
    path = str(folder / "survey.bag")
    with rosbag.Bag(path, "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
    with rosbag.Bag(path) as bag:
        return [message for _, message, _ in bag.read_messages(topics=["/trace"])]


def mcap_traces(folder):
    return traces_of(read_forward((folder / "survey.mcap").read_bytes()))


def lost_traces(data, place, acknowledged):
    """Return what was acknowledged and is not in each of the three forms after the stock repair.

    Raises:
        AssertionError: A form holds a trace with wrong numbers.
    """
    copies = shutil.copytree(str(data), str(place))
    folder = next(Path(copies).iterdir(), None)
    lost = []
    for read in (json_traces, bag_traces, mcap_traces):
        try:
            found = [one if isinstance(one, dict) else vars_of(one) for one in read(folder)]
        except Exception as error:
            # Before the first acknowledgement there may be nothing to read.
            found = []
            if "opened" in acknowledged.done:
                lost.append(f"{read.__name__}: {error!r}")
        for values in found:
            assert_same_numbers(TRACES[values["index"]], values)
        missing = acknowledged.indices - {values["index"] for values in found}
        if missing:
            lost.append(f"{read.__name__} lacks {sorted(missing)}")
    shutil.rmtree(copies)
    return lost


def vars_of(message):
    return {name: getattr(message, name) for name in message.__slots__}


def status_of(folder):
    try:
        return verify_survey(folder).status
    except AnalysisError:
        return None


def check_continues(data, place, acknowledged):
    """Finish the survey in a copy; nothing that was acknowledged may be unknown to it.

    Returns:
        Whether there is a survey that can be resumed.
    """
    copies = Path(shutil.copytree(str(data), str(place)))
    folder = next(copies.iterdir(), None)
    complete = folder is not None and status_of(folder) == COMPLETE
    assert complete or ENDED not in acknowledged.done, verify_survey(folder).faults
    kit = Kit(copies, open_recordings)
    try:
        try:
            reopened = kit.processing.reopen_survey(SURVEY)
        except SurveyRefusedError as error:
            if complete:
                assert error.message.fault_code == "survey.complete"
                assert_whole(folder, TRACES)
                return False
            assert "opened" not in acknowledged.done, f"cannot be reopened: {error}"
            return False
        assert not complete or acknowledged.phase in ("finishing", ENDED)
        assert acknowledged.indices <= set(reopened.stored_indices)
        reported = max([int(one[-1]) for one in acknowledged.done if "report" in one] or [0])
        assert json.loads(reopened.report_json or '{"number": 0}')["number"] >= reported
        kit.finish(TRACES, reopened.stored_indices)
    finally:
        kit.processing.shut_down()
    assert_whole(folder, TRACES)
    assert status_of(folder) == COMPLETE, verify_survey(folder).faults
    shutil.rmtree(str(copies))
    return True
