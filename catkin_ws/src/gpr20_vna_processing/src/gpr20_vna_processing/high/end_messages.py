"""The last messages of a survey, as they are recorded."""

from __future__ import annotations

from typing import Any, List

import rospy

from gpr20_common.high.answers import message_fields
from gpr20_common.high.raw_message import serialized
from gpr20_msgs.msg import ControlStatus
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.trace import utc_time
from gpr20_vna_processing.mid.processing_records import OUTCOMES, SurveyEnd

STATUS_TOPIC = "control_status"
# A coverage with a reason for each of the most samples that a survey may have is smaller.
LARGEST_BYTES = 16 << 20


def end_messages(request: Any, time_ns: int) -> List[RecordedMessage]:
    """Return the last messages that a request to close a survey holds, the status last.

    There are none if the status is of another survey or states another outcome: then the storage
    states the end.
    """
    status = request.status
    _sentence, states = OUTCOMES.get(request.outcome, ("", ()))
    if status.survey_id != request.survey_id or status.code not in states:
        return []
    given = (
        ("control_survey_data", request.progress, False),
        ("survey_coverage", request.coverage, True),
        (STATUS_TOPIC, status, True),
    )
    messages = [
        _recorded(topic, message, time_ns, latching)
        for topic, message, latching in given
        if message.survey_id == request.survey_id
    ]
    return [one for one in messages if len(one.data) <= LARGEST_BYTES]


def end_status(end: SurveyEnd) -> RecordedMessage:
    """Return the last status of a survey whose end only the storage knows."""
    status = ControlStatus(**message_fields(end.message))
    status.header.stamp = rospy.Time(*divmod(end.time_ns, utc_time.NS_PER_S))
    status.code = status.end = int(end.state)
    status.ended = status.header.stamp
    status.survey_id = end.survey_id
    status.simulated = end.simulated
    return _recorded(STATUS_TOPIC, status, end.time_ns, latching=True)


def _recorded(topic: str, message: Any, time_ns: int, latching: bool) -> RecordedMessage:
    return RecordedMessage(
        rospy.resolve_name(topic),
        message._type,
        message._md5sum,
        message._full_text,
        serialized(message),
        time_ns,
        latching,
    )
