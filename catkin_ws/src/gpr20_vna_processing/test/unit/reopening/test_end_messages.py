"""What the node makes of the last status and the reason of a survey; types and bytes of ROS."""

import itertools

import pytest

pytest.importorskip("gpr20_msgs.srv")

from std_msgs.msg import String

from gpr20_common.high.raw_message import serialized
from gpr20_msgs.msg import ControlStatus, Trace
from gpr20_msgs.srv import CloseSurveyRequest
from gpr20_survey.recording import survey_topics
from gpr20_survey.trace import trace_message
from gpr20_vna_processing.high.recorded_messages import end_messages

SURVEY, OTHER = "0f8fad5b-d9cb-469f-a165-70867728950e", "1f8fad5b-d9cb-469f-a165-70867728950e"
CODES = {
    "finished": {ControlStatus.FINISHED},
    "stopped": {ControlStatus.STOPPED},
    "failed": {ControlStatus.FAILED},
    # A main control that is shut down stops; it does not fail.
    "interrupted": {ControlStatus.STOPPED, ControlStatus.FAILED},
}


def request(outcome, code, survey_id=SURVEY):
    status = ControlStatus(code=code, survey_id=survey_id, message="the last one")
    return CloseSurveyRequest(survey_id=SURVEY, outcome=outcome, status=status)


def test_a_last_status_that_does_not_state_the_outcome_of_the_survey_is_left_to_the_storage():
    for outcome, code in itertools.product([*CODES, "", "lost"], range(11)):
        if code in CODES.get(outcome, ()):
            (status,) = end_messages(request(outcome, code), 1)
            assert (status.topic, status.latching) == ("/control_status", True)
        else:
            assert end_messages(request(outcome, code), 1) == []
    for code, survey_id in ((ControlStatus.FINISHED, OTHER), (0, "")):
        asked = request("finished", code, survey_id)
        asked.progress.survey_id = SURVEY  # nor is there an end without its status
        assert end_messages(asked, 1) == []


def test_the_types_and_bytes_of_traces_and_texts_are_those_of_ros():
    assert (Trace._md5sum, Trace._type) == (trace_message.MD5SUM, trace_message.DATATYPE)
    text = survey_topics.TEXT
    assert text == (String._type, String._md5sum, String._full_text)
    topics = survey_topics.SurveyTopics()
    assert topics.metadata("grüße", 1).data == serialized(String("grüße"))
