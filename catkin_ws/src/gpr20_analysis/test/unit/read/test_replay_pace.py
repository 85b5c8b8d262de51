"""A replay keeps the recording's times, scaled."""

import pytest
from fault_kit import raises_fault

from gpr20_analysis.read.replay import Playback
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.recording.mcap_writer import RecordedMessage


class JumpingClock:
    """Lets time pass by what is waited for."""

    def __init__(self):
        self.now = 100.0
        # What happens during a wait; returns how long it took.
        self.on_wait = None

    def now_s(self):
        return self.now

    def wait_s(self, event, timeout_s):
        if self.on_wait is not None:
            timeout_s = self.on_wait(timeout_s)
        self.now += timeout_s
        return event.is_set()


def test_messages_are_due_at_their_recorded_times():
    items = [message("/it", time_s) for time_s in (50.0, 52.0, 51.0, 62.0)]
    for rate, expected_s in ((1.0, [0.0, 2.0, 2.0, 12.0]), (4.0, [0.0, 0.5, 0.5, 3.0])):
        clock = JumpingClock()
        found = [clock.now - 100.0 for _ in Playback(clock, rate).play(items)]
        assert found == pytest.approx(expected_s), rate


def test_a_rate_that_is_none_is_refused():
    for rate in (0.0, -1.0, float("nan"), float("inf")):
        with raises_fault(NOT_ALLOWED):
            Playback(JumpingClock(), rate)


def test_a_replay_pauses_and_changes_its_rate_in_the_middle_of_a_gap():
    clock = JumpingClock()
    playback = Playback(clock)
    happens = [lambda: playback.set_paused(True), lambda: playback.set_paused(False)]
    happens += [lambda: playback.set_rate(10.0)]

    def wait(timeout_s):
        if not happens:
            return timeout_s
        happens.pop(0)()
        return 1.0

    clock.on_wait = wait
    items = [message("/a", 0.0), message("/b", 12.0)]
    assert [one.topic for one in playback.play(items)] == ["/a", "/b"]
    # 1 s, paused for 1 s, another 1 s, then the remaining 10 s ten times as fast.
    assert clock.now - 100.0 == pytest.approx(4.0)
    assert playback.position_s == 12.0


def test_a_replay_that_starts_paused_shows_its_first_moment():
    clock = JumpingClock()
    playback = Playback(clock, paused=True)
    contents = playback.play([message(f"/{one}", at) for one, at in (("a", 5), ("b", 5), ("c", 9))])
    assert (next(contents).topic, next(contents).topic) == ("/a", "/b")
    clock.on_wait = lambda _timeout_s: playback.stop() or 0.0
    assert list(contents) == []


def message(topic, time_s, data=b""):
    kind = "gpr20_msgs/Trace" if topic == "/trace" else "std_msgs/String"
    return RecordedMessage(topic, kind, "", "", data, round(time_s * 1e9))
