"""A replay keeps the recording's times, scaled."""

from __future__ import annotations

import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.playback import Pace, Playback
from gpr20_analysis.read.replay import Due, recorded
from gpr20_survey.recording.recording import RecordedMessage


class JumpingClock:
    """Lets time pass by what is waited for."""

    def __init__(self):
        self.now = 100.0

    def now_s(self):
        return self.now

    def wait_s(self, event, timeout_s):
        self.now += timeout_s
        return event.is_set()


@pytest.mark.parametrize(
    ("pace", "expected_s"),
    [
        (Pace(1.0), [0.0, 2.0, 2.0, 12.0]),
        (Pace(4.0), [0.0, 0.5, 0.5, 3.0]),
        (Pace(1.0, longest_pause_s=3.0), [0.0, 2.0, 2.0, 5.0]),
    ],
)
def test_messages_are_due_at_their_recorded_times(pace, expected_s):
    clock = JumpingClock()
    items = [Due(int(time_s * 1e9), time_s) for time_s in (50.0, 52.0, 51.0, 62.0)]
    found = [clock.now - 100.0 for _ in Playback(pace, clock).play(items)]
    assert found == pytest.approx(expected_s)


def test_a_stopped_replay_yields_nothing_more():
    playback = Playback(Pace(), JumpingClock())
    contents = playback.play([Due(0, "a"), Due(1, "b")])
    assert next(contents) == "a"
    playback.stop()
    assert list(contents) == []


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(AnalysisError, match="rate"):
        Pace(rate)


def test_a_folder_gives_every_recorded_topic_and_files_alone_the_traces(tmp_path):
    folder = make_survey(tmp_path, len(POINTS), "finished")
    topics = [due.content.topic for due in recorded(folder)]
    assert topics.count("/trace") == len(POINTS) and "/survey_metadata" in topics
    traces = [due.content for due in recorded(folder / "traces")]
    assert [trace.index for trace in traces] == list(range(len(POINTS)))
    assert not any(isinstance(trace, RecordedMessage) for trace in traces)
