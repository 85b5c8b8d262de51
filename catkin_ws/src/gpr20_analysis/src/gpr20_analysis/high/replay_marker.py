"""Says on the graph that a replay is running, and takes requests to pause it."""

from __future__ import annotations

from typing import Any

import rospy

from gpr20_analysis.read.playback import Playback
from gpr20_analysis.read.replay import ReplayedSurvey
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.periodic import Periodic
from gpr20_common.message import Message
from gpr20_msgs.msg import Replay
from gpr20_msgs.srv import Command, CommandResponse, SetReplayRate, SetReplayRateResponse
from gpr20_survey.recording.survey_topics import REPLAY_TOPIC

PERIOD_S = 0.5


class ReplayMarker:
    """The latched topic `replay`, and the services beside it.

    Attributes:
        publisher: Of the topic.
    """

    def __init__(self, namespace: str, replayed: ReplayedSurvey, playback: Playback) -> None:
        """Publish the first message.

        Args:
            namespace: Of the replay, absolute, with a slash at its end.
            replayed: The survey.
            playback: What is paused.
        """
        self._replayed = replayed
        self._playback = playback
        self._ended = False
        self.publisher = rospy.Publisher(
            f"{namespace}{REPLAY_TOPIC}", Replay, latch=True, queue_size=10
        )
        self._services = [
            advertise(f"{namespace}pause", Command, self._pause),
            advertise(f"{namespace}continue", Command, self._continue),
            advertise(f"{namespace}set_rate", SetReplayRate, self._set_rate),
        ]
        self._periodic = Periodic(PERIOD_S, self._publish)

    def end(self) -> None:
        """Say that everything is published."""
        self._periodic.stop()
        self._ended = True
        self._publish()

    def _pause(self, _request: Any) -> CommandResponse:
        self._playback.set_paused(True)
        self._publish()
        return CommandResponse(success=True, **message_fields(Message("The replay is paused.")))

    def _continue(self, _request: Any) -> CommandResponse:
        self._playback.set_paused(False)
        self._publish()
        return CommandResponse(success=True, **message_fields(Message("The replay continues.")))

    def _set_rate(self, request: Any) -> SetReplayRateResponse:
        self._playback.set_rate(request.rate)
        self._publish()
        message = Message("The replay runs {rate:g} times as fast.", rate=request.rate)
        return SetReplayRateResponse(success=True, **message_fields(message))

    def _publish(self) -> None:
        survey, playback = self._replayed.survey, self._playback
        state = Replay.PAUSED if playback.paused else Replay.PLAYING
        self.publisher.publish(
            Replay(
                survey_id=survey.survey_id,
                started=survey.started,
                folder=survey.folder,
                state=Replay.ENDED if self._ended else state,
                rate=playback.rate,
                position_s=playback.position_s,
                length_s=self._replayed.length_s,
            )
        )
