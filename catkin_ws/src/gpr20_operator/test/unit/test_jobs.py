"""A job: only its last request may answer. When an image is asked for while somebody looks."""

import map_kit
import pytest
from hypothesis import given
from hypothesis import strategies as st
from result_kit import Now, Requests
from view_kit import SURVEY

from gpr20_common.message import verbatim
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import FEWEST_TRACES, PERIOD_S, Imaging

REASON = verbatim("cancelled")
STEPS = st.lists(
    st.tuples(st.sampled_from(["ask", "end", "progress", "done", "fail"]), st.integers(0, 9)),
    max_size=40,
)


@given(STEPS)
def test_only_the_last_request_answers_and_cancelling_always_ends_it(steps):
    node, results = Requests(), []
    job = Job(node, Service.EXPORT, lambda: 0.0, results.append)
    waiting = None
    for step, which in steps:
        tickets = [one for _kind, one, _fields in node.asked]
        before = job.revision, job.state, job.result, job.problem, job.stage
        ticket = tickets[which % len(tickets)] if tickets else None
        if step in ("ask", "end"):
            job.ask() if step == "ask" else job.end(REASON)
            assert waiting is None or node.cancelled[-1] == waiting.request_id
            assert (job.result, job.problem) == (None, None if step == "ask" else REASON)
            waiting = node.asked[-1][1] if step == "ask" else None
        elif ticket is None:
            continue
        else:
            {"progress": ticket.progress, "done": ticket.done, "fail": ticket.fail}[step](REASON)
            if ticket is not waiting:
                assert (job.revision, job.state, job.result, job.problem, job.stage) == before
            elif step == "progress":
                assert job.running and job.stage == REASON
            else:
                ended = {"done": (JobState.DONE, REASON, None)}
                ended["fail"] = (JobState.FAILED, None, REASON)
                assert (job.state, job.result, job.problem) == ended[step]
                assert step == "fail" or results[-1] == REASON
                waiting = None
        assert job.running == (waiting is not None) and job.revision >= before[0]
    assert len(set(node.cancelled)) == len(node.cancelled)
    assert len({one.request_id for _kind, one, _fields in node.asked}) == len(node.asked)


@pytest.fixture
def imaging(node, now):
    return Imaging(node, now)


def focused(node, survey=SURVEY):
    node.ticket("focus").done(map_kit.focused(survey_id=survey))


CHANGES = st.lists(
    st.tuples(
        st.sampled_from(["", SURVEY, "another"]),
        st.integers(FEWEST_TRACES - 2, FEWEST_TRACES + 2),
        st.sampled_from([None, 4.0, 5.0]),
        st.floats(0.0, 2.0 * PERIOD_S),
        st.booleans(),
    ),
    max_size=20,
)


@given(CHANGES)
def test_an_image_is_asked_for_when_it_would_be_another_and_not_too_often(changes):
    node, now = Requests(), Now()
    imaging = Imaging(node, now)
    asked, ended_s = ("", None, 0), now.s
    waits = False
    for survey, traces, permittivity, passed_s, answered in changes:
        now.s += passed_s
        wanted, before = (survey, permittivity, traces), len(node.of("focus"))
        imaging.keep(*wanted)
        another = wanted[:2] != asked[:2]
        late = another or now.s - ended_s >= PERIOD_S
        due = bool(survey) and traces >= FEWEST_TRACES and wanted != asked and late and not waits
        assert len(node.of("focus")) - before == due
        if due:
            assert node.of("focus")[-1] == (survey,)
            asked, waits = wanted, True
        if waits and answered:
            focused(node, asked[0])
            ended_s, waits = now.s, False


def test_a_failure_is_kept_until_there_is_an_image_and_what_is_awaited_can_be_ended(
    imaging, node, now
):
    imaging.keep(SURVEY, 4.0, 20)
    node.ticket("focus").fail(verbatim("the analysis is not installed"))
    assert str(imaging.problem) == "the analysis is not installed"
    now.s += PERIOD_S
    imaging.keep(SURVEY, 4.0, 20)
    assert len(node.of("focus")) == 2
    node.ticket("focus").fail(verbatim("the analysis is not installed"))
    now.s += PERIOD_S
    imaging.keep(SURVEY, 4.0, 21)
    focused(node)
    assert imaging.problem is None and imaging.pictures.image(SURVEY) is not None
    imaging.keep("another", 4.0, 21)
    imaging.end()
    assert node.cancelled == [node.ticket("focus").request_id]
