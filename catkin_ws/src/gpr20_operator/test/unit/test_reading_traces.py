"""Every page shows the survey that runs, or says that it is another; traces are read once."""

import dataclasses
import random

import pytest
from run_seed import draws
from storage_kit import AskedStorage
from view_kit import (
    FOLDER,
    PAST,
    SURVEY,
    description,
    make_grid,
    snapshot,
    state_of,
    trace_at,
)

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns, coverage_of_stored
from gpr20_operator.ground.traces import RETRY_S, SurveyDescribed, TracePresenter
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey, TracesRead
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.trace.trace import TraceBlock

NEXT = "1b4e28ba-2fa1-41d2-883f-0016d3cca427"
ALL_STORED = tuple(range(40))
GRID = make_grid()


def note(traces, code, survey=SURVEY):
    traces.note_state(snapshot(code, state=state_of(code, survey_id=survey)))


@pytest.fixture
def traces(storage, now):
    """What MAP and RADAR show, without a window."""
    problems = []
    traces = TracePresenter(Imaging(storage, now), problems.append)
    traces.problems = problems
    return traces


def stored(count, survey=SURVEY):
    return coverage_of_stored(survey, 40, range(count))


def read(*indices, unreadable=None, grid=GRID):
    traces = [trace_at(grid, index) for index in indices]
    return TracesRead(TraceBlock.of(grid.survey_id, traces), unreadable or {})


def refresh(traces, times=1):
    for _ in range(times):
        traces.refresh()


CODES = (SurveyState.CHECKING, SurveyState.SURVEYING, SurveyState.PAUSED, SurveyState.FINISHED)
ACTS = ("robot", "described", "trace", "trace", "open", "ask", "read", "back")


class Course:
    """What the robot and people do, in any order, and what every page must show then."""

    def __init__(self):
        self.storage, self.problems = AskedStorage(), []
        imaging = Imaging(self.storage, lambda: 0.0)
        self.traces = TracePresenter(imaging, self.problems.append)
        self.stored = {SURVEY: 0, NEXT: 0, PAST: 12}
        self.running, self.measuring, self.live = "", False, ""
        self.wanted = self.opened = False
        self.answered = 0

    def robot(self, code, survey):
        running = survey if code in RUNNING else ""
        measuring = bool(running) and code is not SurveyState.PAUSED
        if measuring and (not self.measuring or running != self.running):
            self.wanted = self.opened = False
        self.running, self.measuring = running, measuring
        note(self.traces, code, survey)

    def described(self, survey):
        self.live = survey
        self.traces.on_event(SurveyDescribed(description(survey_id=survey)))

    def trace(self, survey, is_lost):
        grid, index = make_grid(survey_id=survey), self.stored[survey]
        self.stored[survey] = min(index + 1, 40)
        if index < 40 and not is_lost:
            self.traces.on_event(trace_at(grid, index))

    def ask(self):
        self.wanted = True
        self.traces.open_survey(FOLDER)

    def read(self):
        # It may come too late.
        if self.storage.of("survey"):
            text = description(survey_id=PAST)
            self.storage.answer(StoredSurvey(text, tuple(range(self.stored[PAST]))))
            self.wanted, self.opened = False, self.opened or self.wanted

    def open(self):
        self.ask()
        self.read()

    def back(self):
        self.wanted = self.opened = False
        self.traces.show_live()

    def settle(self):
        """Let main control report what is stored, and the storage answer what it is asked."""
        if self.live:
            self.traces.on_event(stored(self.stored[self.live], self.live))
        for _ in range(4):
            self.traces.refresh()
            for survey, indices in self.storage.of("traces")[self.answered :]:
                self.answered += 1
                assert max(indices) < self.stored[survey]
                self.storage.answer(read(*indices, grid=make_grid(survey_id=survey)))

    def check(self):
        shown = self.traces.shown
        waits = self.running and self.running != self.live
        expected = PAST if self.opened else "" if waits else self.live
        assert (shown.survey_id, self.traces.band is not None) == (expected, self.opened)
        assert not self.opened or ("NOT THE" in str(self.traces.band)) is bool(self.running)
        count = self.stored.get(expected, 0)
        assert shown.radar.count == len(shown.map.stored) == count
        assert shown.loading.loaded == shown.loading.stored == count


def test_every_page_shows_the_right_survey_and_all_of_its_traces_in_any_course():
    for seed in range(draws(12)):
        source, course = random.Random(seed), Course()
        for _ in range(30):
            act, survey = source.choice(ACTS), source.choice((SURVEY, NEXT))
            values = {"robot": (source.choice(CODES), survey), "described": (survey,)}
            # Stored, and perhaps lost on the topic.
            values["trace"] = (survey, source.random() < 0.5)
            getattr(course, act)(*values.get(act, ()))
            course.settle()
            course.check()
        assert course.problems == [], seed


def test_what_is_stored_and_not_here_yet_is_loading(traces, storage):
    grid = make_grid(50, 25, rotations_deg=(0.0,))
    traces.open_survey(FOLDER)
    parameters = {**grid.plan[0].__dict__, "polarizations_deg": [0.0]}
    text = description(survey_id=PAST, parameters=parameters)
    storage.answer(StoredSurvey(text, tuple(range(1100))))
    requested, shown = [], traces.shown
    assert shown.loading.waiting.sum() == 1100 and not shown.loading.waiting[0, 22:].any()
    refresh(traces, 2)
    while storage.asked[-1] != ("answered",):
        _name, _survey, indices = storage.asked[-1]
        requested += indices
        storage.asked.append(("answered",))
        # The last but one cannot be read.
        some = [one for one in indices if one != 1098]
        why = {1098: verbatim("torn")} if 1098 in indices else None
        storage.answer(read(*some, unreadable=why, grid=shown.map.grid))
        here = len(requested) - (1098 in requested)
        assert (shown.loading.loaded, shown.loading.waiting.sum()) == (here, 1100 - len(requested))
    assert requested == list(range(1100))
    assert (shown.loading.loaded, shown.loading.stored) == (1099, 1099)


def test_a_silent_storage_is_asked_again_and_what_it_cannot_read_is_said_once(traces, storage, now):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(stored(3))
    refresh(traces, 2)
    storage.fail("traces", verbatim("the storage did not answer"))
    refresh(traces, 2)
    assert len(storage.asked) == 1
    now.s += RETRY_S
    refresh(traces, 2)
    storage.answer(read(2, unreadable={1: verbatim("no strict JSON")}))
    refresh(traces, 4)
    assert storage.asked == [("traces", SURVEY, (0, 1, 2))] * 2
    lost = traces.shown.radar.given_up
    assert set(lost) == {0, 1} and lost[1] == verbatim("no strict JSON")
    assert "no file" in str(lost[0])
    # An answer that comes when another survey is shown already.
    traces.on_event(stored(4))
    refresh(traces, 2)
    traces.on_event(SurveyDescribed(description(survey_id=PAST)))
    storage.answer(read(3))
    assert traces.shown.radar.count == 0


def test_what_cannot_be_shown_is_said_and_the_window_goes_on(storage, now):
    for event in (
        SurveyDescribed("{"),
        CoverageRuns(SURVEY, 40, (3,), (0,)),
        CoverageRuns(SURVEY, 41, (0,), (0,)),
        trace_at(GRID, 3, x_coord_mm=1.0),
        dataclasses.replace(trace_at(GRID, 3), index=99),
        StoredSurvey("{}", (0,)),
    ):
        problems = []
        traces = TracePresenter(Imaging(storage, now), problems.append)
        traces.on_event(SurveyDescribed(description()))
        traces.open_survey(FOLDER)
        storage.answer(event) if isinstance(event, StoredSurvey) else traces.on_event(event)
        traces.refresh()
        assert len(problems) == 1, event
        traces.on_event(trace_at(GRID, 0))
        traces.refresh()
        assert traces.shown.radar.count == 1
