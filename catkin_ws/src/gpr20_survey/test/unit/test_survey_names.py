"""Names of surveys and traces; metadata that are kept, and the message of a replay."""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath

from case_kit import each_case
from fault_kit import raises_fault
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from trace_examples import MESSAGES, STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording import survey_topics

DATA = Path("/data")


@each_case(
    "survey_id",
    ["", "../../etc", SURVEY.upper(), f"{SURVEY}\n", f"{SURVEY[:-1]}\u0660", f"{{{SURVEY}}}"],
)
def test_an_id_that_is_no_uuid_never_becomes_a_path(survey_id):
    with raises_fault("value.not_allowed", error=SurveyRefusedError):
        survey_folder.survey_folder(DATA, survey_id, STARTED_US)


@each_case("started_us", [0, 1_000_000_000_000_000])
def test_a_survey_of_1970_is_refused(started_us):
    with raises_fault("clock.wrong", error=SurveyRefusedError):
        survey_folder.survey_folder(DATA, SURVEY, started_us)


def test_a_trace_file_is_named_by_index_and_coordinates():
    trace = make_trace(123, x_coord_mm=50.0, y_coord_mm=-0.001, z_coord_deg=-90.0)
    assert survey_folder.trace_file_name(trace) == "000123_X0050.00_Y0000.00_Z-090.00.json"


@each_case(
    "text, shown",
    [
        ("", ()),
        ("[1]", ("list",)),
        ('{"a": NaN}', ("NaN",)),
        ('{"a": 1e999}', ()),
        ('{"a": ' + "[" * 40 + "]" * 40 + "}", (32,)),
        ('{"a":' * 100_000, (32,)),
        ('{"a": "' + "x" * (1 << 20) + '"}', (1048576,)),
    ],
)
def test_metadata_that_are_no_sane_object_are_refused(text, shown):
    with raises_fault("value.not_allowed", *shown, error=SurveyRefusedError):
        survey_metadata.parse_object(text, "metadata_json")


def test_odd_texts_survive_in_strict_ascii_json():
    values = {"place": "Cañón \ud800 \u2028"}
    assert json.loads(survey_metadata.encode(values)) == values


NAME = "gpr20_msgs/msg/Replay"
TYPES = get_typestore(Stores.ROS1_NOETIC)
TYPES.register(get_types_from_msg((MESSAGES / "Replay.msg").read_text(), NAME))
RECORDED = ("0f8fad5b", "2026-11-22T07:53:11.859801+00:00", "señal \U0001f4a5")


def test_the_definition_and_its_checksum_are_those_of_the_message():
    other = get_typestore(Stores.ROS1_NOETIC)
    other.register(get_types_from_msg(survey_topics.REPLAY_DEFINITION, NAME))
    for types in (TYPES, other):
        assert types.generate_msgdef(NAME)[1] == survey_topics.REPLAY_MD5SUM


def test_another_library_reads_what_is_recorded():
    survey_id, started, folder = RECORDED
    description = {"survey_id": survey_id, "started": started}
    for known, named in ((description, RECORDED), ({}, ("", "", folder))):
        recorded = survey_topics.SurveyTopics().replay(known, PurePosixPath("/data") / folder, 1)
        message = TYPES.deserialize_ros1(recorded.data, NAME)
        assert (message.survey_id, message.started, message.folder) == named
        assert (message.state, message.rate, message.position_s, message.length_s) == (0, 0, 0, 0)
