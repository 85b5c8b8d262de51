from dataclasses import replace

import pytest

from gpr20_common.faults import MAY_MOVE, NOT_RUNNING, PART_LOST
from gpr20_common.message import verbatim
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    LinkState,
    Progress,
    Request,
    StopRequested,
)
from gpr20_survey.faults import NONE_OPEN
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_user_interface.terminal.follower import ExitStatus, Limits, Mode, OnPause, SurveyFollower

LIMITS = Limits(
    wait_s=10.0,
    silence_s=5.0,
    link_down_s=600.0,
    link_back_s=20.0,
    begin_s=10.0,
    stop_s=60.0,
    stop_retry_s=2.0,
)
STARTED = Answer(Request.START, True, verbatim("started"), "ours")


def state(code, survey_id="ours", message="as it is"):
    return ControlState(SurveyState[code], verbatim(message), survey_id, False)


def progress(survey_id="ours"):
    return Progress(survey_id, 50.0, 18, 9, 10.0)


class Robot:
    """The follower with its clock; time passes in steps in which main_control may speak."""

    def __init__(self, clock, mode=Mode.START, on_pause=OnPause.EXIT):
        self.clock = clock
        self.follower = SurveyFollower(mode, on_pause, LIMITS, clock)
        self.requests = []

    def say(self, *events):
        for event in events:
            self.requests += self.follower.handle(event)
        return self

    def wait(self, seconds, spoken=None):
        for _ in range(round(seconds / 0.5)):
            self.clock.advance(0.5)
            if spoken is not None:
                self.requests += self.follower.handle(spoken)
            self.requests += self.follower.tick()
        return self

    @property
    def words(self):
        return str(self.follower.outcome.message)

    @property
    def status(self):
        return self.follower.outcome.status if self.follower.outcome else None


BEGIN = (state("IDLE", ""), STARTED, state("SURVEYING"))


@pytest.fixture
def robot(clock):
    return Robot(clock)


def test_a_survey_whose_end_another_plan_hides_has_ended_as_it_did(clock):
    for end in (SurveyState.FINISHED, SurveyState.FAILED):
        robot = Robot(clock).say(*BEGIN, replace(state("CONFIGURED"), end=end))
        assert (robot.status.name, robot.words) == (end.name, end.name)


@pytest.fixture
def surveying(robot):
    return robot.say(*BEGIN)


def test_starts_when_main_control_is_heard_and_only_once(robot):
    assert robot.requests == []
    # A long start is waited for.
    robot.say(state("IDLE", ""), state("CONFIGURED", ""), progress("")).wait(600, state("HOMING"))
    assert (robot.requests, robot.status) == ([Request.START], None)


def test_the_end_of_the_survey_is_the_outcome_with_its_words(clock):
    for code, status in (
        ("FINISHED", ExitStatus.FINISHED),
        ("FAILED", ExitStatus.FAILED),
        ("STOPPED", ExitStatus.FAILED),
        ("PAUSED", ExitStatus.PAUSED),
    ):
        robot = Robot(clock).say(*BEGIN, state(code, message="why"))
        assert (robot.status, robot.words) == (status, "why")
        # Nothing changes it.
        robot.say(state("FAILED"), StopRequested("Ctrl-C"), STARTED).wait(100)
        assert (robot.status, robot.words) == (status, "why")
        assert robot.requests == [Request.START]
    # A pause is waited for if that is wanted.
    waiting = Robot(clock, on_pause=OnPause.WAIT).say(*BEGIN, state("PAUSED"))
    assert waiting.wait(3600, state("PAUSED")).status is None
    waiting.say(state("SURVEYING"), state("FINISHED"))
    assert waiting.status is ExitStatus.FINISHED


def test_end_of_a_former_survey_is_not_taken_for_ours_and_ours_is_not_missed(robot, clock):
    # The latched status says how the survey before this one ended.
    robot.say(state("FINISHED", "former"), STARTED, state("FINISHED", "former"))
    assert robot.status is None
    robot.say(state("CHECKING"), state("FAILED", message="VNA absent"))
    assert robot.status is ExitStatus.FAILED
    # It ended before the answer came.
    robot = Robot(clock).say(state("IDLE", ""), state("SURVEYING"), state("FINISHED"), STARTED)
    assert robot.status is ExitStatus.FINISHED


def test_refused_start_is_told_with_the_reason_and_nothing_is_accepted_by_itself(robot):
    refused = Answer(Request.START, False, verbatim("the VNA is B, not A"), other_analyzer="B")
    robot.say(state("IDLE", ""), refused)
    assert (robot.status, robot.words) == (ExitStatus.REFUSED, "the VNA is B, not A")
    assert robot.follower.outcome.other_analyzer == "B"
    assert robot.requests == [Request.START]


def test_a_survey_that_is_accepted_with_another_vna_is_followed(clock):
    refused = Answer(Request.RESUME, False, verbatim("the VNA is B, not A"), other_analyzer="B")
    for former in ("PAUSED", "STOPPED", "FAILED"):
        robot = Robot(clock, Mode.RESUME)
        robot.say(state(former), state("CHECKING"), refused)
        assert robot.status is ExitStatus.REFUSED
        assert robot.follower.ask_again() == [Request.RESUME]
        # That of the refused request comes late.
        robot.say(state(former)).wait(60)
        robot.say(state("CHECKING"), Answer(Request.RESUME, True, verbatim("resumed")))
        assert robot.status is None, former
        robot.say(state("SURVEYING"), state("FINISHED"))
        assert robot.status is ExitStatus.FINISHED


def test_absent_main_control_is_waited_for_within_the_limit(robot, clock):
    assert robot.wait(10).status is None
    assert robot.wait(0.5).status is ExitStatus.REFUSED
    assert robot.follower.outcome.message.fault == NOT_RUNNING
    # Nor a survey of which nothing is said.
    robot = Robot(clock).say(state("IDLE", ""), STARTED).wait(11, progress(""))
    assert robot.status is ExitStatus.FAILED
    assert robot.follower.outcome.message.fault == PART_LOST


def test_lost_main_control_is_noticed_even_while_stopping(clock):
    for wish in ((), (StopRequested("Ctrl-C"),)):
        robot = Robot(clock).say(*BEGIN).wait(50, progress()).say(*wish)
        assert robot.wait(5).status is None
        assert robot.wait(0.5).status is ExitStatus.FAILED
        assert robot.follower.outcome.message.may_move


def test_a_link_that_is_down_is_waited_for_within_the_limits(surveying, clock):
    surveying.wait(4).say(LinkState(down=True)).wait(500)
    assert surveying.status is None
    # Topics take a while to be connected again.
    surveying.say(LinkState(down=False)).wait(19)
    assert surveying.status is None
    surveying.wait(20, progress()).say(state("FINISHED"))
    assert surveying.status is ExitStatus.FINISHED
    # Neither it nor the main control for ever.
    robot = Robot(clock).say(*BEGIN, LinkState(down=True)).wait(600)
    assert robot.status is None
    assert robot.wait(0.5).status is ExitStatus.FAILED
    robot = Robot(clock).say(*BEGIN, LinkState(down=True)).wait(60).say(LinkState(down=False))
    assert robot.wait(20).status is None
    assert robot.wait(0.5).status is ExitStatus.FAILED


def test_a_stop_over_a_link_that_is_down_is_repeated_until_it_is_confirmed(surveying):
    surveying.say(LinkState(down=True), StopRequested("Ctrl-C"))
    for _attempt in range(50):
        surveying.say(Answer(Request.STOP, False, verbatim("no answer"))).wait(2.5)
    assert surveying.status is None
    assert surveying.requests.count(Request.STOP) == 51
    surveying.say(LinkState(down=False), state("STOPPED"))
    assert surveying.status is ExitStatus.STOPPED


def test_silence_while_this_process_was_suspended_is_not_main_controls(surveying):
    surveying.clock.advance(3600)
    surveying.requests += surveying.follower.tick()
    assert surveying.status is None
    assert surveying.wait(6).status is ExitStatus.FAILED


def test_main_control_that_forgot_the_survey_ends_the_watch(clock):
    for other in (state("CHECKING", "another"), state("IDLE", ""), state("CONFIGURED", "")):
        robot = Robot(clock).say(*BEGIN, other)
        assert robot.status is ExitStatus.FAILED
        assert "ours" in robot.words
        assert robot.follower.outcome.message.fault_code == PART_LOST.code


def test_stop_is_asked_for_and_believed_only_when_main_control_says_it(clock):
    for end, status in (("STOPPED", ExitStatus.STOPPED), ("FINISHED", ExitStatus.FINISHED)):
        robot = Robot(clock).say(*BEGIN, StopRequested("Ctrl-C"))
        assert robot.requests == [Request.START, Request.STOP]
        robot.say(state("PAUSED"), Answer(Request.STOP, True, verbatim("stopping")))
        assert robot.say(state("STOPPING")).wait(30, state("STOPPING")).status is None
        assert robot.requests == [Request.START, Request.STOP]
        robot.say(state(end, message="by request"))
        assert (robot.status, robot.words) == (status, "by request")


def test_refused_stop_is_tried_again_until_the_limit(surveying):
    refused = Answer(Request.STOP, False, verbatim("busy"))
    surveying.say(StopRequested("Ctrl-C"), refused).wait(2, progress())
    assert surveying.requests.count(Request.STOP) == 2
    surveying.say(refused).wait(58.5, progress())
    assert surveying.status is ExitStatus.FAILED
    assert "busy" in surveying.words
    assert surveying.follower.outcome.message.may_move
    assert surveying.follower.outcome.message.remedy == MAY_MOVE.remedy


def test_stop_before_the_answer_to_start_is_repeated_after_it(robot):
    robot.say(state("IDLE", ""), StopRequested("Ctrl-C"))
    robot.say(Answer(Request.STOP, False, verbatim("no survey runs")), STARTED)
    assert robot.requests == [Request.START, Request.STOP, Request.STOP]
    robot.say(state("STOPPED"))
    assert robot.status is ExitStatus.STOPPED


def test_stop_before_anything_runs_needs_no_confirmation(clock):
    robot = Robot(clock).say(StopRequested("Ctrl-C"))
    assert (robot.status, robot.requests) == (ExitStatus.STOPPED, [])
    refused = Answer(Request.START, False, verbatim("stopped"))
    robot = Robot(clock).say(state("IDLE", ""), StopRequested("Ctrl-C"), refused)
    assert robot.status is ExitStatus.STOPPED
    # A START that never answers.
    robot = Robot(clock).say(state("IDLE", ""), StopRequested("Ctrl-C")).wait(61, progress(""))
    assert robot.status is ExitStatus.FAILED
    assert robot.follower.outcome.message.fault == MAY_MOVE


def test_attaching_needs_a_survey_that_runs_and_asks_for_nothing(clock):
    for code in SurveyState:
        robot = Robot(clock, Mode.ATTACH).say(state(code.name))
        assert (robot.status is ExitStatus.REFUSED) is (code not in RUNNING)
        if code not in RUNNING:
            assert code.name in robot.words
            # Whatever ended the survey before.
            former = ControlState(code, verbatim("x").with_fault(PART_LOST), "former", False)
            message = Robot(clock, Mode.ATTACH).say(former).follower.outcome.message
            assert message.fault_code == NONE_OPEN.code
        elif code is not SurveyState.PAUSED:
            assert robot.follower.survey_id == "ours"
            robot.say(state("FINISHED"))
            assert robot.status is ExitStatus.FINISHED
        assert robot.requests == []


def test_resumed_survey_is_not_left_for_the_pause_it_came_from(clock):
    robot = Robot(clock, Mode.RESUME).say(state("PAUSED"))
    assert robot.requests == [Request.RESUME]
    robot.say(Answer(Request.RESUME, True, verbatim("going on")))
    assert robot.status is None
    robot.say(state("SURVEYING"))
    assert robot.follower.survey_id == "ours"
    robot.say(state("PAUSED", message="again"))
    assert (robot.status, robot.words) == (ExitStatus.PAUSED, "again")
