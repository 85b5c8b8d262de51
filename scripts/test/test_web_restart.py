"""STOP of the page while the node of the page, the main control or the network is away."""

from __future__ import annotations

import contextlib
import time
from typing import Iterator

import pytest
from robot_kit import WEB
from wait_kit import wait_until
from web_site_kit import Site, launched_site
from window_kit import Operator

from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import ENDED, SurveyState

# A kill takes about 13 s.
pytestmark = [pytest.mark.release, pytest.mark.timeout(2600)]

REST_S = 1.0
MAIN_CONTROL = "main_control"
ALARM = """
const alarm = document.querySelector("#stop-warning");
const shown = alarm && alarm.offsetParent !== null;
return [shown ? alarm.innerText : "", shown ? alarm.getBoundingClientRect().width : 0,
  document.documentElement.clientWidth];
"""
NOT_CONFIRMED = "STOP NOT CONFIRMED: use the power switch"


class Surveys:
    """Surveys that are started at the robot, and whether it has stopped."""

    def __init__(self, site: Site) -> None:
        self._site, self.operator = site, Operator()
        self._world = open_shared_state(shared_state_path("/"))

    def start(self) -> None:
        """Start one that lasts longer than any of the tests, once the former is stored."""

        def started() -> bool:
            with contextlib.suppress(SystemExit):
                self.operator.start()
                return True
            return False

        self._site.browser.run("window.isSame = true")
        wait_until(started, "a survey is started")
        wait_until(lambda: self.operator.code not in ENDED, "it is said to run")
        self._site.wait_for_state("SURVEYING")

    def wait_for_end(self) -> None:
        """Return when the survey has ended and no axis gets pulses, and the page says so."""
        wait_until(lambda: self.operator.code in ENDED, "the survey has ended")
        wait_until(lambda: time.monotonic() - self._last_pulse_s > REST_S)
        self.expect_confirmed()

    @property
    def _last_pulse_s(self) -> float:
        return max(self._world.last_pulse_ns(axis) for axis in AxisId) / 1e9

    def expect_alarm(self) -> None:
        browser = self._site.browser
        browser.wait(lambda: NOT_CONFIRMED in browser.run(ALARM)[0], "the alarm is shown", 5.0)
        _text, width_px, page_px = browser.run(ALARM)
        assert width_px == page_px

    def expect_confirmed(self) -> None:
        """Return when the page sends STOP no more: it would stop the next survey, too."""
        browser = self._site.browser
        browser.wait(lambda: browser.run("return sessionStorage.stops") == "[]", "it is confirmed")
        browser.wait(lambda: browser.run(ALARM)[0] == "", "the alarm has ended")
        # The login was not lost, and the page not loaded again.
        assert not browser.run("return document.querySelector('form')")
        assert browser.run("return window.isSame") is True


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with launched_site(tmp_path_factory.mktemp("web"), time_scale=1) as launched:
        launched.log_in("otto")
        yield launched


@pytest.fixture(scope="module")
def surveys(site: Site) -> Surveys:
    return Surveys(site)


# When a person presses: the node that was killed is back after about 4 s.
@pytest.mark.parametrize("late_s", [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0])
def test_stop_pressed_while_the_node_is_killed_stops_the_robot_when_it_is_back(
    site: Site, surveys: Surveys, late_s: float
) -> None:
    surveys.start()
    site.robot.processes()[WEB].kill()
    time.sleep(late_s)
    site.browser.run("document.querySelector('#stop').click()")
    # Later, the node may be back before the alarm is due.
    if late_s < 3.0:
        surveys.expect_alarm()
    surveys.wait_for_end()


@pytest.mark.parametrize("after_ms", [0, 5, 20, 50, 200])
def test_stop_that_the_node_has_just_taken_is_not_lost_with_it(
    site: Site, surveys: Surveys, after_ms: int
) -> None:
    surveys.start()
    process = site.robot.processes()[WEB]
    site.browser.run("document.querySelector('#stop').click()")
    time.sleep(after_ms / 1e3)
    process.kill()
    surveys.wait_for_end()


@pytest.mark.parametrize("kill", [False, True])
def test_stop_is_confirmed_only_by_a_main_control_that_answers(
    site: Site, surveys: Surveys, kill: bool
) -> None:
    surveys.start()
    process = site.robot.processes()[MAIN_CONTROL]
    # The watchdog kills what does not answer.
    process.kill() if kill else process.suspend()
    site.browser.press("#stop")
    if not kill:
        surveys.expect_alarm()
    surveys.expect_confirmed()
    rests = (*ENDED, SurveyState.IDLE, SurveyState.CONFIGURED)
    wait_until(lambda: surveys.operator.code in rests, "no survey runs")


def test_stop_without_a_network_is_carried_out_when_it_is_back(
    site: Site, surveys: Surveys
) -> None:
    driver = site.browser.driver
    surveys.start()
    cut = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": True, **cut})
    site.browser.press("#stop")
    surveys.expect_alarm()
    assert surveys.operator.code not in ENDED
    driver.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": False, **cut})
    surveys.wait_for_end()
