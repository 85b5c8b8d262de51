"""The topics of a recording have one type each."""

from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.topic_types import MAX_RENAMED, TopicTypes

OLD, NEW = "7b530785257ca423f317a80d75c5dad5", "0123456789abcdef0123456789abcdef"


def status(md5sum: str) -> RecordedMessage:
    return RecordedMessage("/status", "gpr20_msgs/ControlStatus", md5sum, "", b"", 0)


def names(types, *md5sums):
    return [types.named(status(md5sum)).topic for md5sum in md5sums]


def test_the_first_type_of_a_topic_has_its_name_and_others_have_their_own():
    types = TopicTypes({})
    assert names(types, OLD, NEW, OLD) == ["/status", "/status_01234567", "/status"]


def test_a_type_that_a_recording_holds_already_has_the_name():
    assert names(TopicTypes({"/status": {OLD}}), NEW, OLD) == ["/status_01234567", "/status"]


def test_a_survey_that_is_resumed_again_uses_the_same_names():
    again = TopicTypes({"/status": {OLD}, "/status_01234567": {NEW}})
    assert names(again, NEW, OLD) == ["/status_01234567", "/status"]


def test_a_topic_with_far_too_many_types_is_not_recorded_for_ever():
    types = TopicTypes({"/status": {OLD}})
    found = [types.named(status(f"{number:032x}"[::-1])) for number in range(2 * MAX_RENAMED)]
    assert sum(one is not None for one in found) == MAX_RENAMED
    assert types.named(status(OLD)).topic == "/status"
