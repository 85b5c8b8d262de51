"""A job: only its last request may answer. When the window asks for a focused image."""

import map_kit
import pytest
from hypothesis import given
from hypothesis import strategies as st
from view_kit import SURVEY

from gpr20_common.message import verbatim
from gpr20_operator.jobs.job import Job, JobState
from gpr20_operator.jobs.pictures import (
    FEWEST_TRACES,
    PERIOD_S,
    SETTLED_S,
    Imaging,
    Wanted,
)

REASON = verbatim("cancelled")
STEPS = st.lists(
    st.tuples(st.sampled_from(["ask", "end", "progress", "done", "fail"]), st.integers(0, 9)),
    max_size=40,
)


@given(STEPS)
def test_only_the_last_request_answers_and_cancelling_always_ends_it(steps):
    cancelled, results, tickets = [], [], []
    job = Job(tickets.append, cancelled.append, lambda: 0.0, results.append)
    waiting = None
    for step, which in steps:
        before = job.revision, job.state, job.result, job.problem, job.stage
        ticket = tickets[which % len(tickets)] if tickets else None
        if step in ("ask", "end"):
            job.ask() if step == "ask" else job.end(REASON)
            assert waiting is None or cancelled[-1] == waiting.request_id
            assert (job.result, job.problem) == (None, None if step == "ask" else REASON)
            waiting = tickets[-1] if step == "ask" else None
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
    assert len(set(cancelled)) == len(cancelled)
    assert len({one.request_id for one in tickets}) == len(tickets)


def test_a_result_that_is_refused_is_a_failure_with_its_reason():
    job = Job(
        lambda ticket, **sent: ticket.done(sent), str, lambda: 0.0, lambda _: job.refuse(REASON)
    )
    job.ask(survey="a")
    assert (job.state, job.result, job.problem) == (JobState.FAILED, None, REASON)


@pytest.fixture
def imaging(node, now):
    return Imaging(node, now)


WANTED = Wanted(SURVEY, 20, 4.0)


def focused(node, survey=SURVEY):
    node.ticket("focus").done(map_kit.focused(survey_id=survey))


def test_new_traces_lead_to_a_new_image_at_most_every_10_s(imaging, node, now):
    imaging.keep(WANTED._replace(traces=FEWEST_TRACES - 1))  # too few
    imaging.keep(Wanted("", 100, 4.0))
    assert node.asked == []
    for step in range(40):
        now.s += 1.0
        imaging.keep(WANTED._replace(traces=20 + step))
        if step % 3 == 0:
            focused(node)
    # An answer comes up to three seconds later.
    assert 3 <= len(node.of("focus")) <= 5
    assert imaging.pictures.image(SURVEY) is not None


def test_nothing_is_asked_without_new_traces_or_while_an_answer_is_on_its_way(imaging, node, now):
    imaging.keep(WANTED)
    for expected in (1, 2, 2):
        for _ in range(100):
            imaging.keep(WANTED._replace(traces=30))
            now.s += 1.0
        assert len(node.of("focus")) == expected
        focused(node)


def test_another_survey_is_asked_for_at_once_and_another_soil_when_it_rests(imaging, node, now):
    imaging.keep(WANTED)
    focused(node)
    imaging.keep(WANTED._replace(survey_id="another"))
    focused(node, "another")
    assert [one[0] for one in node.of("focus")] == [SURVEY, "another"]
    for permittivity in (5.0, 6.0, 7.0):
        now.s += SETTLED_S / 2
        imaging.keep(Wanted("another", 20, permittivity))
    assert len(node.of("focus")) == 2
    now.s += SETTLED_S
    imaging.keep(Wanted("another", 20, 7.0))
    assert node.of("focus")[-1] == ("another", 7.0)


def test_a_failure_is_kept_until_there_is_an_image(imaging, node, now):
    imaging.keep(WANTED)
    node.ticket("focus").fail(verbatim("the analysis is not installed"))
    assert str(imaging.problem) == "the analysis is not installed"
    imaging.keep(WANTED)
    assert len(node.of("focus")) == 1
    now.s += PERIOD_S
    imaging.keep(WANTED._replace(traces=21))
    focused(node)
    assert imaging.problem is None


def test_what_is_awaited_ends_with_the_window(imaging, node):
    imaging.keep(WANTED)
    imaging.end()
    assert node.cancelled == [node.ticket("focus").request_id]
