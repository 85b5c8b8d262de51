"""A job: only its last request may answer. When an image is asked for while somebody looks."""

from hypothesis import given
from hypothesis import strategies as st
from map_kit import focused
from result_kit import Requests
from view_kit import PAST, SURVEY

from gpr20_common.message import verbatim
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import FEWEST_TRACES, PERIOD_S, Imaging

REASON = verbatim("cancelled")
STEPS = st.lists(
    st.tuples(
        st.sampled_from(["ask", "end", "cancel", "progress", "done", "fail"]), st.integers(0, 9)
    ),
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
        if step == "cancel":
            job.cancel(REASON)
            # Files may be written until the node answers.
            stopped = waiting and (waiting.request_id, REASON)
            assert not stopped or (node.cancelled[-1], job.stage) == stopped
        elif step in ("ask", "end"):
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
    assert len({one.request_id for _kind, one, _fields in node.asked}) == len(node.asked)


def test_an_image_is_asked_for_when_it_would_be_another_and_not_too_often(node, now):
    imaging = Imaging(node, now)
    few, many = FEWEST_TRACES - 1, FEWEST_TRACES
    for survey, permittivity, traces, later_s, asks in (
        *(("", 4.0, many, 0.0, False), (SURVEY, 4.0, few, 0.0, False)),
        *((SURVEY, 4.0, many, 0.0, True), (SURVEY, 4.0, many, PERIOD_S, False)),
        *((SURVEY, 4.0, many + 1, 0.0, True), (SURVEY, 4.0, many + 2, PERIOD_S / 2.0, False)),
        # Another permittivity or survey does not wait.
        *((SURVEY, 5.0, many + 2, 0.0, True), (PAST, 5.0, many + 2, 0.0, True)),
    ):
        now.s += later_s
        asked = len(node.of("focus"))
        imaging.keep(survey, permittivity, traces)
        assert (len(node.of("focus")) > asked) is asks, (permittivity, traces, later_s)
        if asks:
            assert node.of("focus")[-1] == (survey,)
            imaging.keep(survey, 9.0, traces)
            assert len(node.of("focus")) == asked + 1, "one at a time"
            node.ticket("focus").done(focused(survey_id=survey))
    # A failure is said, and the image asked for again after a while.
    for _again in range(2):
        now.s += PERIOD_S
        imaging.keep(PAST, 5.0, many + 3)
        node.ticket("focus").fail(REASON)
        imaging.keep(PAST, 5.0, many + 3)
        assert imaging.problem == REASON
    assert len(node.of("focus")) == 6
