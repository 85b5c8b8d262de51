import pytest
from test_fault_messages import ASKED_STOP, MOVING

from gpr20_common import remedies
from gpr20_common.message import in_a_row, verbatim
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_user_interface import faults
from gpr20_user_interface.mid.events import (
    Answer,
    ControlState,
    LinkState,
    Progress,
    Request,
    StopRequested,
)
from gpr20_user_interface.mid.survey_follower import Limits, Mode, OnPause, SurveyFollower
from gpr20_user_interface.mid.survey_outcome import ExitStatus
from gpr20_user_interface.mid.survey_session import first_step, outcome_lines

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
    def status(self):
        return self.follower.outcome.status if self.follower.outcome else None


@pytest.fixture
def robot(clock):
    return Robot(clock)


@pytest.fixture
def surveying(robot):
    return robot.say(state("IDLE", ""), STARTED, state("SURVEYING"))


def test_starts_when_main_control_is_heard_and_only_once(robot):
    assert robot.requests == []
    robot.say(state("IDLE", ""), state("CONFIGURED", ""), progress(""))
    assert robot.requests == [Request.START]


def test_finished_survey_is_a_success(surveying):
    surveying.say(state("FINISHED", message="18 traces in /data"))
    assert surveying.status is ExitStatus.FINISHED
    assert str(surveying.follower.outcome.message) == "18 traces in /data"


@pytest.mark.parametrize("code", ["FAILED", "STOPPED"])
def test_other_ends_without_a_wish_are_failures(surveying, code):
    surveying.say(state(code, message="why"))
    assert (surveying.status, str(surveying.follower.outcome.message)) == (ExitStatus.FAILED, "why")


def test_end_of_a_former_survey_is_not_taken_for_ours(robot):
    # The latched status says how the survey before this one ended.
    robot.say(state("FINISHED", "former"), STARTED, state("FINISHED", "former"))
    assert robot.status is None
    robot.say(state("CHECKING"), state("FAILED", message="VNA absent"))
    assert robot.status is ExitStatus.FAILED


def test_survey_that_ended_before_the_answer_came_is_not_missed(robot):
    robot.say(state("IDLE", ""), state("SURVEYING"), state("FINISHED"), STARTED)
    assert robot.status is ExitStatus.FINISHED


def test_refused_start_is_told_with_the_reason(robot):
    robot.say(state("IDLE", ""), Answer(Request.START, False, verbatim("axes are not there")))
    assert robot.status is ExitStatus.REFUSED
    assert str(robot.follower.outcome.message) == "axes are not there"


def test_another_vna_ends_with_its_identity_and_nothing_is_accepted_by_itself(robot):
    refused = Answer(Request.START, False, verbatim("the VNA is B, not A"), other_analyzer="B")
    robot.say(state("IDLE", ""), refused)
    assert robot.status is ExitStatus.REFUSED
    assert robot.follower.outcome.other_analyzer == "B"


@pytest.mark.parametrize("former", ["PAUSED", "STOPPED", "FAILED"])
def test_a_survey_that_is_accepted_with_another_vna_is_followed(clock, former):
    robot = Robot(clock, Mode.RESUME)
    refused = Answer(Request.RESUME, False, verbatim("the VNA is B, not A"), other_analyzer="B")
    robot.say(state(former), state("CHECKING"), refused)
    assert robot.status is ExitStatus.REFUSED
    assert robot.follower.ask_again() == [Request.RESUME]
    # That of the refused request comes late.
    robot.say(state(former)).wait(60)
    robot.say(state("CHECKING"), Answer(Request.RESUME, True, verbatim("resumed")))
    assert robot.status is None
    robot.say(state("SURVEYING"), state("FINISHED"))
    assert robot.status is ExitStatus.FINISHED


def test_absent_main_control_is_waited_for_within_the_limit(robot):
    assert robot.wait(10).status is None
    assert robot.wait(0.5).status is ExitStatus.REFUSED
    assert robot.follower.outcome.message.fault == faults.NO_CONTROL


def test_long_start_is_waited_for(robot):
    robot.say(state("IDLE", "")).wait(600, state("HOMING"))
    assert robot.status is None


def test_survey_nothing_is_said_about_is_not_followed_for_ever(robot):
    robot.say(state("IDLE", ""), STARTED).wait(11, progress(""))
    assert robot.status is ExitStatus.FAILED
    assert robot.follower.outcome.message.fault == faults.CONTROL_LOST


@pytest.mark.parametrize("wish", [[], [StopRequested("Ctrl-C")]])
def test_lost_main_control_is_noticed_even_while_stopping(surveying, wish):
    surveying.wait(50, progress()).say(*wish)
    assert surveying.wait(5).status is None
    assert surveying.wait(0.5).status is ExitStatus.FAILED
    assert surveying.follower.outcome.message.may_move


def test_a_link_that_is_down_is_waited_for(surveying):
    surveying.wait(4).say(LinkState(down=True)).wait(500)
    assert surveying.status is None
    # Topics take a while to be connected again.
    surveying.say(LinkState(down=False)).wait(19)
    assert surveying.status is None
    surveying.wait(20, progress()).say(state("FINISHED"))
    assert surveying.status is ExitStatus.FINISHED


def test_a_link_that_stays_down_ends_the_watch(surveying):
    surveying.say(LinkState(down=True)).wait(600)
    assert surveying.status is None
    assert surveying.wait(0.5).status is ExitStatus.FAILED


def test_a_main_control_that_has_not_come_back_with_its_link_ends_the_watch(surveying):
    surveying.say(LinkState(down=True)).wait(60).say(LinkState(down=False))
    assert surveying.wait(20).status is None
    assert surveying.wait(0.5).status is ExitStatus.FAILED


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


@pytest.mark.parametrize(
    "other", [state("CHECKING", "another"), state("IDLE", ""), state("CONFIGURED", "")]
)
def test_main_control_that_forgot_the_survey_ends_the_watch(surveying, other):
    surveying.say(other)
    assert surveying.status is ExitStatus.FAILED
    assert "ours" in str(surveying.follower.outcome.message)
    assert surveying.follower.outcome.message.fault_code == faults.CONTROL_RESTARTED.code


def test_pause_is_left_or_waited_for(clock):
    begin = (state("IDLE", ""), STARTED, state("SURVEYING"), state("PAUSED", message="no VNA"))
    leaving = Robot(clock).say(*begin)
    assert (leaving.status, str(leaving.follower.outcome.message)) == (ExitStatus.PAUSED, "no VNA")
    waiting = Robot(clock, on_pause=OnPause.WAIT).say(*begin)
    assert waiting.wait(3600, state("PAUSED")).status is None
    waiting.say(state("SURVEYING"), state("FINISHED"))
    assert waiting.status is ExitStatus.FINISHED


def test_stop_is_asked_for_and_believed_only_when_main_control_says_it(surveying):
    surveying.say(StopRequested("Ctrl-C"))
    assert surveying.requests == [Request.START, Request.STOP]
    surveying.say(Answer(Request.STOP, True, verbatim("stopping")), state("STOPPING"))
    assert surveying.wait(30, state("STOPPING")).status is None
    assert surveying.requests == [Request.START, Request.STOP]
    surveying.say(state("STOPPED", message="by request"))
    assert (surveying.status, str(surveying.follower.outcome.message)) == (
        ExitStatus.STOPPED,
        "by request",
    )


def test_stop_that_comes_too_late_leaves_a_finished_survey(surveying):
    surveying.say(StopRequested("Ctrl-C"), state("FINISHED"))
    assert surveying.status is ExitStatus.FINISHED


def test_refused_stop_is_tried_again_until_the_limit(surveying):
    refused = Answer(Request.STOP, False, verbatim("busy"))
    surveying.say(StopRequested("Ctrl-C"), refused).wait(2, progress())
    assert surveying.requests.count(Request.STOP) == 2
    surveying.say(refused).wait(58.5, progress())
    assert surveying.status is ExitStatus.FAILED
    assert "busy" in str(surveying.follower.outcome.message)
    assert surveying.follower.outcome.message.may_move
    assert surveying.follower.outcome.message.remedy == faults.STOP_UNCONFIRMED.remedy


def test_stop_in_the_pause_does_not_leave_the_survey_paused(surveying):
    surveying.say(StopRequested("Ctrl-C"), state("PAUSED"))
    assert surveying.status is None


def test_stop_before_the_answer_to_start_is_repeated_after_it(robot):
    robot.say(state("IDLE", ""), StopRequested("Ctrl-C"))
    robot.say(Answer(Request.STOP, False, verbatim("no survey runs")), STARTED)
    assert robot.requests == [Request.START, Request.STOP, Request.STOP]
    robot.say(state("STOPPED"))
    assert robot.status is ExitStatus.STOPPED


def test_stop_before_a_refused_start_needs_no_confirmation(robot):
    robot.say(
        state("IDLE", ""),
        StopRequested("Ctrl-C"),
        Answer(Request.START, False, verbatim("stopped")),
    )
    assert robot.status is ExitStatus.STOPPED


def test_start_that_never_answers_can_be_left_by_stop(robot):
    robot.say(state("IDLE", ""), StopRequested("Ctrl-C")).wait(61, progress(""))
    assert robot.status is ExitStatus.FAILED


def test_stop_before_anything_began_asks_for_nothing(robot):
    robot.say(StopRequested("Ctrl-C"))
    assert (robot.status, robot.requests) == (ExitStatus.STOPPED, [])


@pytest.mark.parametrize("code", sorted(set(SurveyState) - RUNNING))
def test_attaching_needs_a_survey_that_runs(clock, code):
    robot = Robot(clock, Mode.ATTACH).say(state(code.name))
    assert (robot.status, robot.requests) == (ExitStatus.REFUSED, [])
    assert code.name in str(robot.follower.outcome.message)


def test_attaching_to_a_stopped_survey_says_that_an_axis_still_moves(clock):
    stopped = ControlState(SurveyState.STOPPED, in_a_row([ASKED_STOP, MOVING]), "ours", True)
    outcome = Robot(clock, Mode.ATTACH).say(stopped).follower.outcome
    assert outcome.message.fault_code == "axis.still_moving"
    assert first_step(outcome.message) in outcome_lines(outcome, "", False)
    assert first_step(outcome.message).values["remedy"] == remedies.MOTORS_OFF


def test_attached_survey_is_followed_without_asking_for_anything(clock):
    robot = Robot(clock, Mode.ATTACH).say(state("SURVEYING"))
    assert robot.follower.survey_id == "ours"
    robot.say(state("FINISHED"))
    assert (robot.status, robot.requests) == (ExitStatus.FINISHED, [])


def test_resumed_survey_is_not_left_for_the_pause_it_came_from(clock):
    robot = Robot(clock, Mode.RESUME).say(state("PAUSED"))
    assert robot.requests == [Request.RESUME]
    robot.say(Answer(Request.RESUME, True, verbatim("going on")))
    assert robot.status is None
    robot.say(state("SURVEYING"))
    assert robot.follower.survey_id == "ours"
    robot.say(state("PAUSED", message="again"))
    assert (robot.status, str(robot.follower.outcome.message)) == (ExitStatus.PAUSED, "again")


def test_nothing_changes_the_outcome(surveying):
    surveying.say(state("FINISHED"))
    outcome = surveying.follower.outcome
    surveying.say(state("FAILED"), StopRequested("Ctrl-C"), STARTED).wait(100)
    assert surveying.follower.outcome is outcome
    assert surveying.requests == [Request.START]


def test_only_words_about_this_survey_concern_the_operator(robot):
    robot.say(state("FINISHED", "former"))
    assert not robot.follower.concerns(progress("former"))
    robot.say(STARTED, state("SURVEYING"))
    assert robot.follower.concerns(progress("ours"))
    assert not robot.follower.concerns(progress("former"))
