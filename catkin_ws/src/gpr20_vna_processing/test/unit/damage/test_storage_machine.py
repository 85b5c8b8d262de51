"""Random requests to the storage while its disk is full, loses its power or its process is killed.

Whatever happens: each trace that was acknowledged is in its JSON file and in the MCAP, each that is
stored is published once by a process, nothing else is stored, and every survey can be finished.
`tools/fault_suite` adds facts too.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, Set

from failing_disk import FailingDisk, Failure
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from planned_survey import METADATA, POINTS, planned_trace
from reopening_kit import assert_whole
from run_seed import draws
from storage_kit import OTHER_SURVEY, Kit, text_message
from trace_examples import STARTED_US, SURVEY, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.folder.survey_folder import MCAP_FILE, SURVEY_FILE, survey_folder
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.survey_topics import recorded_trace
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

# Nothing is written between requests, so that each example can be repeated.
LIMITS = ProcessingParameters(timeout_s=20.0, commit_period_s=1000.0)
TRACES = {
    survey: [planned_trace(index, survey) for index in range(len(POINTS))]
    for survey in (SURVEY, OTHER_SURVEY)
}
SURVEYS = st.sampled_from([SURVEY, SURVEY, SURVEY, OTHER_SURVEY])
POWER_CUTS = st.builds(
    Failure, st.integers(0, 50), st.just(True), st.sampled_from([0.0, 0.5, 1.0]), st.integers(0, 99)
)
FULL_DISKS = st.builds(Failure, st.integers(0, 50), st.just(False))
FAILURES = st.none() | st.none() | FULL_DISKS | POWER_CUTS


@dataclass
class Known:
    """What the storage has acknowledged of a survey, and what it may have done beside that."""

    is_open: bool = False
    """Whether its opening was acknowledged, ever."""
    stored: Dict[int, object] = field(default_factory=dict)
    uncertain: Set[int] = field(default_factory=set)
    """Traces that were sent and not acknowledged."""
    outcome: str = ""
    may_have_ended: bool = False
    """Whether a close was begun that was not acknowledged."""

    @property
    def has_content(self) -> bool:
        """Whether anything was stored since it was opened, for certain."""
        return bool(self.stored or self.outcome)


class StorageMachine(RuleBasedStateMachine):
    """Makes requests, and compares each answer and what is on the disk with what is known."""

    def __init__(self):
        super().__init__()
        # In memory: what is durable is for the model to say, not for the disk below.
        self.place = Path(tempfile.mkdtemp(dir="/dev/shm"))
        self.processes = 0
        self.data = self.place / "0"
        self.data.mkdir()
        self.disk = FailingDisk(self.data)
        self.known = {survey: Known() for survey in TRACES}
        self.published = set()
        self.requests = 0
        self.begin_process()

    def begin_process(self):
        self.kit = Kit(self.data, limits=LIMITS)
        self.current = ""
        self.opened_new = self.closing = False

    def teardown(self):
        try:
            for survey, known in self.known.items():
                if known.is_open:
                    self.finish(survey)
            self.kit.processing.shut_down()
        finally:
            self.disk.release()
            shutil.rmtree(str(self.place))

    def folder_of(self, survey):
        return survey_folder(self.data, survey, STARTED_US)

    def request(self, work, allowed, failure=None):
        """Make a request; return its answer, None if there was none, or the code of the refusal.

        Args:
            work: Makes the request.
            allowed: Codes with which it may be refused; "" if it may succeed.
            failure: What the disk does meanwhile.
        """
        self.requests += 1
        place = self.place / str(self.requests)
        with self.disk.failing(failure, place):
            try:
                answer = work()
                assert "" in allowed, f"not refused, but may only be: {allowed}"
            except StorageFailedError as error:
                assert self.disk.has_failed, error
                answer = None
            except ProcessingError as error:
                answer = error.message.fault_code
                assert answer in allowed, error
        if place.exists():
            self.restart_on(place)
        else:
            self.current = self.kit.processing.state().survey_id
        return answer

    def restart_on(self, place):
        """Begin a process on what a power cut has left."""
        self.note_published()
        with contextlib.suppress(ProcessingError):
            self.kit.processing.shut_down()
        self.disk.take_over(place)
        shutil.rmtree(str(self.data))
        self.data = place
        for survey, known in self.known.items():
            if known.is_open:
                mcap = StoredMcap(self.folder_of(survey) / MCAP_FILE)
                found = [recorded_trace(message) for message in mcap.messages()]
                prints = {one.fingerprint() for one in found if one is not None}
                assert {one.fingerprint() for one in known.stored.values()} <= prints
        self.begin_process()

    def note_published(self):
        found = [(trace.survey_id, trace.index) for trace in self.kit.stored]
        assert len(found) == len(set(found)), "published twice"
        self.published |= set(found)

    @initialize(survey=SURVEYS, traces=st.integers(-1, 5))
    def begin(self, survey, traces):
        """Most examples begin with a survey that has some traces."""
        if traces >= 0:
            self.open(survey, None)
        for _ in range(traces):
            self.store(survey, 0, False, None)

    @rule(survey=SURVEYS, failure=FAILURES)
    def open(self, survey, failure):
        known, before = self.known[survey], self.current
        if self.current:
            again = self.current == survey and self.opened_new
            allowed = [""] if again else ["survey.other_open"]
        elif known.is_open and known.has_content:
            allowed = ["survey.folder_exists"]
        else:
            # A failed opening can be repeated, until something followed it.
            exists = self.folder_of(survey).exists()
            allowed = ["", "survey.folder_exists"] if exists else [""]
        folder = self.request(
            lambda: self.kit.open(survey, metadata_json=METADATA), allowed, failure
        )
        if folder == self.folder_of(survey):
            known.is_open = True
            if not before:
                known.may_have_ended = False
                known.uncertain.clear()
            self.opened_new = self.current == survey
        elif folder is None and not self.current and not known.has_content:
            # It removes what an opening that nothing followed has left, and begins again.
            known.is_open = False

    @rule(survey=SURVEYS, back=st.integers(0, 2), other=st.booleans(), failure=FAILURES)
    def store(self, survey, back, other, failure):
        """Store the next trace, or a former one again, as it was or with other numbers."""
        known = self.known[survey]
        following = next((i for i in range(len(POINTS)) if i not in known.stored), len(POINTS))
        index = min(max(following - back, 0), len(POINTS) - 1)
        trace = TRACES[survey][index]
        other = other and index in known.stored
        if other:
            trace = planned_trace(index, survey, antennae_height_m=0.7)
        if not self.current:
            allowed = ["survey.none_open"]
        elif self.closing:
            allowed = ["", "survey.closing", "survey.other_open", "trace.already_stored"]
        elif survey != self.current:
            allowed = ["survey.other_open"]
        else:
            allowed = ["trace.already_stored"] if other else [""]
        self.kit.processing.record(text_message("/t", f"before {index}"))
        process = self.kit
        path = self.request(lambda: self.kit.processing.store(trace), allowed, failure)
        if isinstance(path, Path):
            known.stored[index] = trace
            known.uncertain.discard(index)
            assert (survey, index) in {(one.survey_id, one.index) for one in process.stored} or (
                (survey, index) in self.published
            )
        elif path is None and index not in known.stored:
            known.uncertain.add(index)

    @rule(survey=SURVEYS, outcome=st.sampled_from(["finished", "stopped"]), failure=FAILURES)
    def close(self, survey, outcome, failure):
        known = self.known[survey]
        if self.current:
            allowed = [""] if survey == self.current else ["survey.other_open"]
        else:
            allowed = ["", "survey.none_open"]
        was_current = self.current == survey
        closed = self.request(
            lambda: self.kit.processing.close_survey(survey, outcome), allowed, failure
        )
        if was_current and closed is None:
            known.may_have_ended = True
            self.closing = bool(self.current)
        elif was_current:
            self.note_end(survey, outcome)
            stored = known.stored.keys()
            assert len(stored) <= closed.stored_traces <= len(stored | known.uncertain)
        elif closed is not None and not isinstance(closed, str):
            assert known.outcome or known.may_have_ended

    def note_end(self, survey, outcome):
        known = self.known[survey]
        known.outcome, known.may_have_ended = outcome, False
        self.closing = False
        description = read_json(self.folder_of(survey) / SURVEY_FILE)
        assert description["outcome"] == outcome

    @rule(survey=SURVEYS, failure=FAILURES)
    def interrupt_other(self, survey, failure):
        before = self.current
        answer = self.request(lambda: self.kit.processing.interrupt_other(survey), [""], failure)
        if before in ("", survey):
            assert answer == ""
        elif answer is None:
            self.known[before].may_have_ended = True
            self.closing = bool(self.current)
        else:
            assert answer == self.folder_of(before).name
            self.note_end(before, "interrupted")

    @rule(survey=SURVEYS, by_folder=st.booleans(), failure=FAILURES)
    def reopen(self, survey, by_folder, failure):
        known = self.known[survey]
        complete = len(known.stored.keys() | known.uncertain) == len(POINTS)
        if known.may_have_ended:
            allowed = ["", "survey.other_open", "survey.closing", "survey.complete"]
        elif self.current:
            allowed = ["survey.other_open"] if self.current != survey else [""]
            allowed = ["survey.closing", *allowed] if self.closing else allowed
        elif known.is_open and complete and known.outcome == "finished":
            allowed = ["survey.complete"]
        else:
            allowed = [""]
        if not known.is_open:
            allowed = ["", "survey.unknown", "survey.description_lost", "survey.other_open"]
        name = self.folder_of(survey).name if by_folder else survey
        process, before = self.kit, self.current
        answer = self.request(lambda: self.kit.processing.reopen_survey(name), allowed, failure)
        if answer is None and survey == before:
            known.may_have_ended = known.may_have_ended or not self.current
        if answer is None or isinstance(answer, str):
            return
        known.is_open, known.outcome = True, ""
        known.may_have_ended = False
        stored = set(answer.stored_indices)
        assert known.stored.keys() <= stored <= known.stored.keys() | known.uncertain
        known.stored.update({index: TRACES[survey][index] for index in stored})
        known.uncertain.clear()
        published = {(one.survey_id, one.index) for one in process.stored} | self.published
        assert {(survey, index) for index in stored} <= published
        if self.current:
            self.opened_new = self.opened_new and before == survey
            self.closing = False

    @rule()
    def restart(self):
        """End the process as its supervisor does, and begin another."""
        self.note_published()
        survey = self.current
        self.kit.processing.shut_down()
        if survey:
            self.note_end(survey, "interrupted")
        self.begin_process()

    @rule(failure=POWER_CUTS)
    def lose_power(self, failure):
        self.request(lambda: None, [""], failure)

    @invariant()
    def what_was_acknowledged_is_in_the_folder(self):
        for survey, known in self.known.items():
            if known.is_open:
                folder = self.folder_of(survey)
                files = {int(one.name[:6]) for one in folder.glob("traces/*.json")}
                assert known.stored.keys() <= files <= known.stored.keys() | known.uncertain

    def finish(self, survey):
        """Store what is missing and finish; then the survey is complete for every reader."""
        self.note_published()
        known, processing = self.known[survey], self.kit.processing
        with contextlib.suppress(ProcessingError):
            if self.closing:
                processing.close_survey(self.current, "stopped")
        processing.interrupt_other(survey)
        try:
            stored = processing.reopen_survey(survey).stored_indices
        except ProcessingError as error:
            assert error.message.fault_code == "survey.complete"
            assert known.outcome == "finished" or known.may_have_ended
        else:
            assert known.stored.keys() <= set(stored) <= known.stored.keys() | known.uncertain
            for trace in TRACES[survey]:
                if trace.index not in stored:
                    processing.store(trace)
            processing.close_survey(survey, "finished")
        assert_whole(self.folder_of(survey), TRACES[survey])
        found = verify_survey(self.folder_of(survey))
        assert found.status == COMPLETE, found.faults


StorageMachine.TestCase.settings = settings(max_examples=draws(30), stateful_step_count=25)
TestStorageMachine = StorageMachine.TestCase
