"""A job: it is asked for, reports, can be cancelled, and only its last request may answer."""

from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import verbatim
from gpr20_operator.jobs.job import Job, JobState

REASON = verbatim("cancelled")
STEPS = st.lists(
    st.tuples(st.sampled_from(["ask", "end", "progress", "done", "fail"]), st.integers(0, 9)),
    max_size=40,
)


class Clock:
    now_s = 0.0


def new_job(tickets, cancelled, results, clock=Clock):
    return Job(tickets.append, cancelled.append, lambda: clock.now_s, results.append)


@given(STEPS)
def test_only_the_last_request_answers_and_cancelling_always_ends_it(steps):
    cancelled, results, tickets = [], [], []
    job = new_job(tickets, cancelled, results)
    waiting = None
    for number, (step, which) in enumerate(steps):
        before = job.revision, job.state, job.result, job.problem, job.stage
        ticket = tickets[which % len(tickets)] if tickets else None
        if step == "ask":
            ended = waiting
            job.ask()
            waiting = tickets[-1]
            assert ended is None or cancelled[-1] == ended.request_id
            assert job.running and job.result is None and job.problem is None
        elif step == "end":
            job.end(REASON)
            assert waiting is None or cancelled[-1] == waiting.request_id
            assert (job.state, job.problem, job.result) == (JobState.READY, REASON, None)
            waiting = None
        elif ticket is None:
            continue
        elif ticket is not waiting:
            {"progress": ticket.progress, "done": ticket.done, "fail": ticket.fail}[step](REASON)
            assert (job.revision, job.state, job.result, job.problem, job.stage) == before
        elif step == "progress":
            ticket.progress(REASON)
            assert job.running and job.stage == REASON
        elif step == "done":
            ticket.done(number)
            assert (job.state, job.result, results[-1]) == (JobState.DONE, number, number)
            waiting = None
        else:
            ticket.fail(REASON)
            assert (job.state, job.problem) == (JobState.FAILED, REASON)
            waiting = None
        assert job.running == (waiting is not None)
        assert job.revision >= before[0]
    assert len(set(cancelled)) == len(cancelled)
    assert len({one.request_id for one in tickets}) == len(tickets)


def test_it_counts_the_seconds_of_the_request_that_runs():
    clock = Clock()
    tickets = []
    job = new_job(tickets, [], [], clock)
    clock.now_s = 10.0
    assert job.running_s == 0.0
    job.ask()
    clock.now_s = 13.5
    assert job.running_s == 3.5
    tickets[0].done(None)
    assert job.running_s == 0.0


def test_the_fields_of_a_request_are_sent_and_it_may_be_answered_at_once():
    results = []
    job = Job(
        *(lambda ticket, **fields: ticket.done(fields), lambda _id: None),
        *(lambda: 0.0, results.append),
    )
    job.ask(survey="a", permittivity=4.0)
    assert job.state is JobState.DONE
    assert results == [job.result] == [{"survey": "a", "permittivity": 4.0}]


def test_a_result_that_is_refused_is_a_failure_with_its_reason():
    tickets = []
    job = Job(tickets.append, str, lambda: 0.0, lambda _result: job.refuse(REASON))
    job.ask()
    tickets[0].done("of another survey")
    assert (job.state, job.result, job.problem) == (JobState.FAILED, None, REASON)
