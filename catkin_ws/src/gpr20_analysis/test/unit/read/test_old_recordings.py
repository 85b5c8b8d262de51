"""Lists of candidates in recordings of earlier versions are completed."""

import io

import pytest

pytest.importorskip("gpr20_msgs.msg")

from candidate_examples import candidate, candidate_list
from genpy.dynamic import generate_dynamic

from gpr20_analysis.high.old_recordings import completed
from gpr20_common.high.raw_message import serialized
from gpr20_msgs.msg import CandidateList
from gpr20_survey.high.candidate_topics import list_message
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.results.candidates import Flag

DATATYPE = "gpr20_msgs/CandidateList"
# What later versions have added.
ADDED = ("uint32 omitted_primary", "AreaPosition[] position")
FORMER = "\n".join(
    line for line in CandidateList._full_text.splitlines() if not line.startswith(ADDED)
)


def test_a_former_list_of_candidates_is_completed():
    found = candidate_list([candidate(flags=[Flag.UNRATED, Flag.EDGE])], omitted=3)
    message = list_message(found)
    former_type = generate_dynamic(DATATYPE, FORMER)[DATATYPE]
    former = former_type(*(getattr(message, name) for name in former_type.__slots__))
    data = io.BytesIO()
    former.serialize(data)
    recorded = RecordedMessage(
        "/candidates", DATATYPE, former_type._md5sum, FORMER, data.getvalue(), 0
    )
    now = completed(recorded)
    assert (now.md5sum, now.topic) == (CandidateList._md5sum, "/candidates")
    assert now.data == serialized(message)
    received = CandidateList()
    received.deserialize(now.data)
    assert received == message


def test_a_list_of_today_is_left_as_it_is():
    data = serialized(list_message(candidate_list([candidate()])))
    recorded = RecordedMessage(
        "/candidates", DATATYPE, CandidateList._md5sum, CandidateList._full_text, data, 0
    )
    assert completed(recorded) == recorded
