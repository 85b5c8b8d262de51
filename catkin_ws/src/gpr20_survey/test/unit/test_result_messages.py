"""What was found in a survey comes out of its ROS message as it went in."""

from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case

pytest.importorskip("gpr20_msgs.msg")

from candidate_examples import WORDS, candidate, candidate_list, numbers
from hypothesis import given
from hypothesis import strategies as st
from trace_examples import make_trace

from gpr20_common.errors import InvalidValueError
from gpr20_common.high.answers import fields_of, record_of
from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import Message
from gpr20_doctor.high.node_reports import analyzer_test_of
from gpr20_main_control.high.main_control_node import analyzer_test_fields
from gpr20_msgs.msg import SurveySummary
from gpr20_msgs.srv import FocusSurveyResponse, ReopenSurveyResponse, TestAnalyzerResponse
from gpr20_survey.faults import VNA_FAILED
from gpr20_survey.results import answers

MESSAGES = st.none() | st.builds(
    lambda word: Message("the fault is {what}", what=word), WORDS.filter(bool)
)
COUNTS = st.integers(0, 2**31)


def sent(message):
    """Return a message as another node receives it."""
    return deserialized(type(message), serialized(message))


LEVELS = np.linspace(-3.0, 40.0, 24, dtype="<f4").reshape(2, 3, 4)
IMAGE = answers.FocusedImage(
    20, np.arange(4.0), np.arange(3.0), np.arange(2.0), LEVELS, candidate_list([candidate()])
)


def test_a_focused_image():
    levels = LEVELS.copy()
    levels[0, 0, 0] = np.nan
    image = replace(IMAGE, levels_db=levels)
    answer = FocusSurveyResponse(**answers.focus_fields(image))
    received = answers.image_from(sent(answer))
    assert (received.traces, received.found) == (20, image.found)
    for name in ("x_mm", "y_mm", "depth_mm", "levels_db"):
        np.testing.assert_array_equal(getattr(received, name), getattr(image, name))


@each_case(
    "wrong",
    [
        {"levels_db": b"123"},
        {"x_mm": [0.0, 5.0, 5.0, 15.0]},
        {"y_mm": [0.0, float("nan"), 10.0]},
        {"depth_mm": []},
        {"candidates_json": "{}"},
    ],
)
def test_a_broken_image_is_refused(wrong):
    with pytest.raises(InvalidValueError):
        answers.image_from(FocusSurveyResponse(**{**answers.focus_fields(IMAGE), **wrong}))


@st.composite
def summaries(draw):
    columns, rows = draw(st.integers(0, 5)), draw(st.integers(0, 5))
    percent = draw(st.binary(min_size=columns * rows, max_size=columns * rows))
    sizes = (float(draw(st.integers(0, 800))), float(draw(st.integers(0, 800))))
    return answers.SurveySummary(
        *(draw(WORDS) for _ in range(4)),
        *(draw(COUNTS), draw(COUNTS), draw(MESSAGES)),
        *(draw(st.booleans()), draw(st.booleans()), draw(MESSAGES)),
        *(draw(WORDS), draw(WORDS)),
        *(*sizes, columns, rows, percent),
        *(draw(WORDS) for _ in range(2)),
    )


@given(summaries())
def test_a_summary(summary):
    message = SurveySummary(**fields_of(summary, SurveySummary))
    assert record_of(answers.SurveySummary, sent(message)) == summary


@given(
    st.builds(
        answers.AnalyzerTest, WORDS, WORDS, WORDS, COUNTS, numbers(0.0), numbers(), failure=MESSAGES
    )
)
def test_a_test_of_the_analyzer(test):
    assert analyzer_test_of(sent(TestAnalyzerResponse(**analyzer_test_fields(test)))) == test


def test_why_a_test_of_the_analyzer_failed():
    failure = Message("no VNA").with_fault(VNA_FAILED)
    fields = analyzer_test_fields(answers.AnalyzerTest("a", failure=failure))
    received = analyzer_test_of(sent(TestAnalyzerResponse(**fields))).failure
    assert (received, received.cause) == (failure, VNA_FAILED)


@given(
    st.builds(
        answers.ReopenedSurvey,
        *(WORDS, WORDS, WORDS, WORDS),
        st.lists(COUNTS).map(tuple),
        st.sampled_from([None, make_trace()]),
        interrupted=WORDS,
    )
)
def test_a_reopened_survey(reopened):
    fields = {**fields_of(reopened, ReopenSurveyResponse), "recent": []}
    answer = sent(ReopenSurveyResponse(**fields))
    assert record_of(answers.ReopenedSurvey, answer, recent=reopened.recent) == reopened
