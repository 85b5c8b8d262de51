"""STOP of the page while the node of the page, the main control or the network is away.

The figures of docs/evidence/web_page.md: pytest -s -m release scripts/test/test_web_restart.py
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from typing import Iterator, List

import pytest
from robot_kit import WEB
from wait_kit import wait_until
from web_site_kit import Site, launched_site
from window_kit import Operator

from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import ENDED, SurveyState

# A kill takes about 13 s.
pytestmark = [pytest.mark.release, pytest.mark.timeout(2600)]

KILLS, LATEST_S = 20, 6.0
LIMIT_S, REST_S = 60.0, 1.0
MAIN_CONTROL = "main_control"
ALARM = """
const alarm = document.querySelector("#stop-warning");
const shown = alarm && alarm.offsetParent !== null;
return [shown ? alarm.innerText : "", shown ? alarm.getBoundingClientRect().width : 0,
  document.documentElement.clientWidth];
"""
NOT_CONFIRMED = "STOP NOT CONFIRMED: use the power switch"


class Survey:
    """Surveys of the robot, and when it has stopped."""

    def __init__(self) -> None:
        self.operator = Operator()
        self._world = open_shared_state(shared_state_path("/"))

    def start(self, site: Site) -> None:
        """Start one that lasts longer than any of the tests, once the former is stored."""

        def started() -> bool:
            with contextlib.suppress(SystemExit):
                self.operator.start()
                return True
            return False

        wait_until(started, "a survey is started")
        wait_until(lambda: not self.is_over, "it is said to run")
        site.wait_for_state("SURVEYING")

    @property
    def is_over(self) -> bool:
        return self.operator.code in ENDED

    def wait_for_end(self) -> float:
        """Return when the last pulse of any axis was, and the survey had ended [s]."""
        wait_until(lambda: self.is_over, "the survey has ended")
        ended_s = time.monotonic()
        wait_until(lambda: time.monotonic() - self._last_pulse_s > REST_S)
        return max(ended_s, self._last_pulse_s)

    @property
    def _last_pulse_s(self) -> float:
        return max(self._world.last_pulse_ns(axis) for axis in AxisId) / 1e9


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with launched_site(tmp_path_factory.mktemp("web"), time_scale=1) as launched:
        launched.log_in("otto")
        yield launched


@pytest.fixture(scope="module")
def survey(site: Site) -> Survey:
    return Survey()


def _answers(site: Site) -> bool:
    port = int(site.address.rpartition(":")[2])
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
        return True
    return False


def _expect_alarm(site: Site, name: str) -> None:
    browser = site.browser
    browser.wait(lambda: NOT_CONFIRMED in browser.run(ALARM)[0], "the alarm is shown", 5.0)
    _text, width_px, page_px = browser.run(ALARM)
    assert width_px == page_px
    browser.keep_picture(name)


def _expect_none(site: Site) -> None:
    browser = site.browser
    browser.wait(lambda: browser.run(ALARM)[0] == "", "the alarm has ended")
    # The login was not lost, and the page not loaded again.
    assert not browser.run("return document.querySelector('form')")
    assert browser.run("return window.isSame") is True


def test_stop_pressed_while_the_node_is_killed_stops_the_robot_when_it_is_back(
    site: Site, survey: Survey
) -> None:
    browser, found_s = site.browser, []  # type: ignore[var-annotated]
    browser.run("window.isSame = true")
    for number in range(KILLS):
        survey.start(site)
        late_s = LATEST_S * number / (KILLS - 1)
        returned: List[float] = []
        process = site.robot.processes()[WEB]
        process.kill()
        killed_s = time.monotonic()

        def note_return() -> None:
            wait_until(lambda: not _answers(site), "the node is dead")
            wait_until(lambda: _answers(site), "the node is back")
            returned.append(time.monotonic())  # noqa: B023

        watch = threading.Thread(target=note_return)
        watch.start()
        # Not for a condition: this is when a person presses.
        time.sleep(max(0.0, killed_s + late_s - time.monotonic()))
        browser.run("document.querySelector('#stop').click()")
        pressed_s = time.monotonic()
        # Later, the node may be back before the alarm is due.
        if late_s < LATEST_S / 2.0:
            _expect_alarm(site, f"web_stop_alarm_{number}")
        stopped_s = survey.wait_for_end()
        watch.join(LIMIT_S)
        found_s.append(stopped_s - max(pressed_s, returned[0]))
        print(
            f"\nSTOP {pressed_s - killed_s:.1f} s after the kill, node back after "
            f"{returned[0] - killed_s:.1f} s, stopped {found_s[-1]:.2f} s later",
            end="",
        )
        _expect_none(site)
    print(f"\nat most {max(found_s):.2f} s after the return of the node")


@pytest.mark.parametrize("after_ms", [0, 5, 20, 50, 200])
def test_stop_that_the_node_has_just_taken_is_not_lost_with_it(
    site: Site, survey: Survey, after_ms: int
) -> None:
    site.browser.run("window.isSame = true")
    survey.start(site)
    process = site.robot.processes()[WEB]
    site.browser.run("document.querySelector('#stop').click()")
    time.sleep(after_ms / 1e3)
    process.kill()
    survey.wait_for_end()
    # The next test kills the next node, and must not take the state of this survey for its own.
    wait_until(lambda: _answers(site), "the node is back")
    wait_until(lambda: "SURVEYING" not in site.browser.text("#state"), "the page is back")
    _expect_none(site)


def test_stop_is_confirmed_only_by_a_main_control_that_answers(site: Site, survey: Survey) -> None:
    browser = site.browser
    browser.run("window.isSame = true")
    for kill in (False, True):
        survey.start(site)
        process = site.robot.processes()[MAIN_CONTROL]
        # The watchdog kills what does not answer.
        process.kill() if kill else process.suspend()
        browser.press("#stop")
        if not kill:
            _expect_alarm(site, "web_stop_alarm_main_control")
        browser.wait(lambda: browser.run("return sessionStorage.stops") == "[]", "it is confirmed")
        _expect_none(site)
        wait_until(
            lambda: survey.operator.code in (*ENDED, SurveyState.IDLE, SurveyState.CONFIGURED),
            what="no survey runs",
        )


def test_stop_without_a_network_is_carried_out_when_it_is_back(site: Site, survey: Survey) -> None:
    browser = site.browser
    browser.run("window.isSame = true")
    survey.start(site)
    cut = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    browser.driver.execute_cdp_cmd("Network.enable", {})
    browser.driver.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": True, **cut})
    browser.press("#stop")
    _expect_alarm(site, "web_stop_alarm_network")
    assert not survey.is_over
    browser.driver.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": False, **cut})
    back_s = time.monotonic()
    stopped_s = survey.wait_for_end()
    print(f"\nnetwork: stopped {stopped_s - back_s:.2f} s after its return")
    _expect_none(site)
