"""Lists of candidates in recordings of earlier versions."""

import pytest

pytest.importorskip("gpr20_msgs.msg")

from candidate_examples import candidate, candidate_list
from genpy.dynamic import generate_dynamic

from gpr20_analysis.high.old_recordings import completed
from gpr20_common.high.raw_message import serialized
from gpr20_msgs.msg import CandidateList
from gpr20_survey.high.candidate_topics import list_message
from gpr20_survey.recording.recording import RecordedMessage

DATATYPE = "gpr20_msgs/CandidateList"
# Its levels were above noise, and its false alarms a probability: it says something else.
FORMER = CandidateList._full_text.replace("above_clutter_db", "above_noise_db").replace(
    "false_alarms_per_m2      #", "false_alarm_probability  #"
)


def test_a_former_list_of_candidates_is_not_said_to_be_one_of_today():
    former_type = generate_dynamic(DATATYPE, FORMER)[DATATYPE]
    recorded = RecordedMessage("/candidates", DATATYPE, former_type._md5sum, FORMER, b"", 0)
    assert former_type._md5sum != CandidateList._md5sum
    assert completed(recorded) == recorded


def test_a_list_of_today_is_left_as_it_is():
    data = serialized(list_message(candidate_list([candidate()])))
    recorded = RecordedMessage(
        "/candidates", DATATYPE, CandidateList._md5sum, CandidateList._full_text, data, 0
    )
    assert completed(recorded) == recorded
