"""Several robots share a master: the window names its robot, and the operator can choose."""

import random
import sys

import pytest
from view_kit import snapshot
from window_helpers import show

from gpr20_common.message import verbatim
from gpr20_doctor.low.masters import robots_on_master
from gpr20_operator.robot.events import ControlState, Request
from gpr20_operator.robot.robots import RobotReported, Robots, RobotsFound
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.low.process import NAMESPACE, command, with_namespace

MEASURING = ControlState(SurveyState.SURVEYING, verbatim("Measuring"), "id", True)


@pytest.fixture
def window(opened, request):
    """A window of one of the robots on a master, and what it asks for."""
    watched, chosen = [], []
    given = getattr(request, "param", ("/robot1", True))
    window = opened(robots=Robots(*given, watched.append, chosen.append))
    window.watched, window.chosen = watched, chosen
    return window


def found(window, *namespaces):
    window.on_event(RobotsFound(frozenset(namespaces)))
    for _ in range(2):  # the bar names the robot with the next refresh
        show(window, window.survey.snapshot)


def test_only_a_main_control_that_starts_surveys_is_a_robot():
    both = ("start_survey", "stop_survey")
    services = [f"{robot}/{name}" for robot in ("", "/robot1", "/field/a") for name in both]
    services += ["/robot2/start_survey", "/robot3/stop_survey", "/robot4/restart_survey"]
    for seed in range(5):
        random.Random(seed).shuffle(services)
        assert robots_on_master(services) == {"/", "/robot1", "/field/a"}


def test_other_robots_are_listed_in_the_settings_and_listened_to_meanwhile(window):
    found(window, "/robot1")
    window.rail.settings.click()
    assert not window.settings.robot_button.isVisible()
    assert not window.top_bar.band.message.whole.startswith("robot1")
    found(window, "/robot1", "/robot2", "/robot3")
    window.settings.robot_button.click()
    sheet = window.robots
    assert sheet.isVisible() and window.watched == [True]
    window.on_event(RobotReported("/robot2", MEASURING))
    show(window, window.survey.snapshot)
    texts = [button.text() for button in sheet.buttons if button.isVisible()]
    assert texts == ["robot1\nno report yet", "robot2\nSURVEYING", "robot3\nno report yet"]
    assert [button.isEnabled() for button in sheet.buttons[:3]] == [False, True, True]
    sheet.close_button.click()
    assert window.watched == [True, False] and not sheet.isVisible()


def test_every_robot_can_be_reached_but_for_one_whose_stop_is_not_answered(window):
    names = [f"/robot{number:02d}" for number in range(1, 30)]
    found(window, "/robot1", *names)
    window.settings.robot_button.click()
    show(window, snapshot(SurveyState.SURVEYING, pending=frozenset({Request.STOP})))
    assert not any(button.isEnabled() for button in window.robots.buttons[:2])
    show(window, snapshot(SurveyState.STOPPED))
    for button in window.robots.buttons:
        if button.isEnabled():
            button.click()
    assert window.chosen == names


def test_a_window_without_a_robot_proposes_those_that_there_are_once(window):
    show(window, snapshot(alive=False))
    found(window, "/robot2", "/robot3")
    assert not window.robots.isVisible()  # its own may be starting
    window.clock.advance(6.0)
    show(window, snapshot(alive=False))
    assert window.robots.isVisible()
    window.robots.close_button.click()
    show(window, snapshot(alive=False))
    assert not window.robots.isVisible()


@pytest.mark.parametrize("window", [("/", False)], indirect=True)
def test_the_window_of_a_real_robot_stays_with_it(window):
    window.clock.advance(6.0)
    found(window, "/robot2")
    show(window, snapshot(alive=False))
    assert not window.robots.isVisible()
    window.rail.settings.click()
    assert not window.settings.robot_button.isVisible()
    assert window.top_bar.band.message.whole.startswith("/: ")


def test_the_next_window_has_the_options_of_this_one_and_a_name_of_its_own():
    words = ["/x/user_interface", "_language:=es", "__name:=user_interface", "__ns:=/robot1"]
    assert command("/robot2", words) == [
        *(sys.executable, "/x/user_interface", "_language:=es", "__ns:=/robot2")
    ]
    environment = {"DISPLAY": ":0", NAMESPACE: "/robot1"}
    assert with_namespace("/robot2", environment) == {"DISPLAY": ":0", NAMESPACE: "/robot2"}
