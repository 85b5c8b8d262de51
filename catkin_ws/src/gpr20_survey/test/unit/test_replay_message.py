"""The message by which a replay is recognized is gpr20_msgs/Replay."""

from pathlib import PurePosixPath

import pytest
from case_kit import each_case
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from trace_examples import MESSAGES

from gpr20_survey.recording import replay_message
from gpr20_survey.recording.replay_message import RecordedSurvey

NAME = "gpr20_msgs/msg/Replay"
TYPES = get_typestore(Stores.ROS1_NOETIC)
TYPES.register(get_types_from_msg((MESSAGES / "Replay.msg").read_text(), NAME))
SURVEY = RecordedSurvey("0f8fad5b", "2026-11-22T07:53:11.859801+00:00", "señal \U0001f4a5")


def test_the_definition_and_its_checksum_are_those_of_the_message():
    other = get_typestore(Stores.ROS1_NOETIC)
    other.register(get_types_from_msg(replay_message.DEFINITION, NAME))
    for types in (TYPES, other):
        assert types.generate_msgdef(NAME)[1] == replay_message.MD5SUM


def test_another_library_reads_what_is_recorded():
    message = TYPES.deserialize_ros1(SURVEY.encode(), NAME)
    found = (message.survey_id, message.started, message.folder)
    assert found == (SURVEY.survey_id, SURVEY.started, SURVEY.folder)
    assert (message.state, message.rate, message.position_s, message.length_s) == (0, 0, 0, 0)
    assert RecordedSurvey.decode(SURVEY.encode()) == SURVEY


@each_case("size", range(12))
def test_a_message_that_is_cut_off_is_refused(size):
    with pytest.raises(ValueError, match="incomplete"):
        RecordedSurvey.decode(bytes(size))


@each_case("description", [{}, {"survey_id": 7, "started": None}])
def test_a_description_that_is_not_whole_gives_the_folder_alone(description):
    survey = RecordedSurvey.of(description, PurePosixPath("/data/20260921T141320_0f8fad5b"))
    assert survey == RecordedSurvey("", "", "20260921T141320_0f8fad5b")
