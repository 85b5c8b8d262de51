"""The page at a distance in a real browser, with the whole simulated robot behind it."""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
from importlib.util import find_spec
from pathlib import Path
from typing import Iterator, List, Sequence, Set

import pytest
from browser_kit import HEIGHTS, Browser
from robot_kit import WATCHDOG, WEB
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from translation_kit import english_words
from web_site_kit import Site, launched_site

# A link that loses STOP, and PAUSE once `losePause` is called.
LOSE = """
const { fetch } = window;
window.fetch = (address, options) => {
  const lost = new TypeError("lost");
  if (address.startsWith("/api/stop")) return Promise.reject(lost);
  if (!address.startsWith("/api/pause")) return fetch(address, options);
  return new Promise((_, reject) => { window.losePause = () => reject(lost); });
};
"""
# As after an hour of sleep; every stream that is opened is counted.
SLEEP = """
const { now } = Date;
Date.now = () => now() + 3600000;
window.streams = 0;
window.EventSource = class extends EventSource {
  constructor(address) {
    super(address);
    window.streams++;
  }
};
"""
IS_STALE = "return document.body.classList.contains('stale')"
DIALOG = """
const dialog = document.createElement("dialog");
dialog.append(document.createElement("h2"));
document.body.append(dialog);
dialog.showModal();
"""
# The first STOP and the first question for the words are lost.
BAD_FROM_THE_START = """{
  const { fetch } = window;
  window.asked = [];
  window.fetch = (address, options) => {
    window.asked.push(address.split("?")[0]);
    const isLost = window.asked.length <= 2;
    return isLost ? Promise.reject(new TypeError("lost")) : fetch(address, options);
  };
}"""
# The ground is never answered; how many of its requests are open, at any time and at STOP.
SLOW_GROUND = """
const { fetch } = window;
Object.assign(window, { asked: 0, open: 0 });
window.fetch = (address, options) => {
  if (address.startsWith("/api/stop")) window.openAtStop = window.open;
  if (!address.startsWith("/api/ground?")) return fetch(address, options);
  window.asked++;
  window.open++;
  return new Promise((_, reject) => options.signal.addEventListener("abort", () => {
    window.open--;
    reject(options.signal.reason);
  }));
};
"""
# Another page is in control, and an axis moves after STOP.
MOVES = """
window.EventSource = class extends EventSource {
  set onmessage(take) {
    super.onmessage = ({ data }) => {
      const changes = JSON.parse(data);
      changes.holder = { name: "ana", mark: "other" };
      changes.stop_warning = { title: "MOTORS", text: "X axis: MOVES" };
      take({ data: JSON.stringify(changes) });
    };
  }
};
dispatchEvent(new PageTransitionEvent("pageshow", { persisted: true }));
"""
# How wide the alarm is, and how wide the page.
ALARM_WIDTHS = """
const { width } = document.querySelector("#stop-warning").getBoundingClientRect();
return [width, document.documentElement.clientWidth];
"""
# Whether everybody can use a page: WCAG 2.1 A and AA by axe-core, and the keyboard.
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
RUN_AXE = """
const done = arguments[arguments.length - 1];
axe.run(document, { runOnly: arguments[0], resultTypes: ["violations"] }).then(({ violations }) =>
  done(violations.flatMap(({ id, nodes }) =>
    nodes.map((node) => `${id}: ${node.html.slice(0, 120)} ${node.failureSummary}`))));
"""
# What a person can use, in the order of the document; of radio buttons one is enough.
CONTROLS = """
return [...document.querySelectorAll(
  "a[href], button, input, select, textarea, summary, [tabindex='0']")]
  .filter((one) => !one.disabled && one.checkVisibility({ visibilityProperty: true }))
  .filter((one) => one.type !== "radio" || one.checked);
"""

IS_SHOWN = """
const [control] = arguments;
return control === document.activeElement && getComputedStyle(control).outlineStyle !== "none";
"""


def violations(browser: Browser) -> List[str]:
    """Return what breaks a rule on the page that is shown."""
    if browser.run("return !window.axe"):
        browser.run(_axe())
    found: List[str] = browser.driver.execute_async_script(RUN_AXE, RULES)
    return found


def _axe() -> str:
    # The package is there for this file alone: nothing of it is imported.
    found = find_spec("axe_playwright_python")
    assert found is not None and found.origin is not None
    return Path(found.origin).with_name("axe.min.js").read_text("utf-8")


def _begin_at_the_top(browser: Browser) -> None:
    # Without a place of its own, Tab continues where the focus was before.
    browser.run(
        "document.body.tabIndex = -1; document.body.focus();"
        "document.body.removeAttribute('tabindex'); window.scrollTo(0, 0)"
    )


def tab_reaches_all(browser: Browser) -> bool:
    """Return whether Tab reaches every control, in the order of the page, and shows where it is.

    A page that is drawn again meanwhile is not what was expected: then it is asked again.
    """
    expected = browser.run(CONTROLS)
    _begin_at_the_top(browser)
    for control in expected:
        ActionChains(browser.driver).send_keys(Keys.TAB).perform()
        if not browser.run(IS_SHOWN, control):
            return False
    return bool(expected)


def press_by_keyboard(browser: Browser, element_id: str, most_tabs: int = 40) -> None:
    """Press a button by Tab and Enter alone."""
    _begin_at_the_top(browser)
    for _ in range(most_tabs):
        ActionChains(browser.driver).send_keys(Keys.TAB).perform()
        if browser.run("return document.activeElement.id") == element_id:
            ActionChains(browser.driver).send_keys(Keys.ENTER).perform()
            return
    raise AssertionError(f"Tab does not reach {element_id}")


PAGES = ("now", "map", "surveys", "more", "service")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    # That it answers shows that a port that was taken has kept it away only until it was free.
    with launched_site(tmp_path_factory.mktemp("web"), time_scale=10) as launched:
        yield launched


def _survey(site: Site, points: int) -> subprocess.Popen:
    options = ("--x-points", str(points), "--y-points", str(points))
    return site.robot.client(*options, stdout=subprocess.DEVNULL)


def test_a_doctor_beside_the_robot_finds_no_fault(site: Site) -> None:
    command = ["rosrun", "gpr20_doctor", "doctor", "--json", "--wait", "60"]
    printed = subprocess.run(command, stdout=subprocess.PIPE, check=False, timeout=200.0).stdout
    found = {one["check"]: one for one in reversed(json.loads(printed)["findings"])}
    # The surveys of this test are in /tmp, which a real robot must not use.
    assert found.pop("config_files")["fault_code"] == "config.wrong"
    # They depend on the computer that runs the test.
    for check in ("data_disk", "memory", "volumes"):
        found.pop(check, None)
    bad = {name: one for name, one in found.items() if one["level"] not in ("OK", "NOTE")}
    assert bad == {}
    assert {found[one]["level"] for one in ("calibration", "versions")} == {"OK"}
    assert found["x_axis/axis_driver"]["level"] == "NOTE"


def test_survey_is_started_watched_paused_resumed_and_stopped_from_the_page(site: Site) -> None:
    browser, screen = site.browser, site.screen
    screen.arming.touched()
    site.log_in("otto")
    browser.wait(lambda: screen.arming.web and screen.arming.web.watchers, "the window knows of it")
    assert screen.arming.web is not None
    assert re.fullmatch(r"([0-9A-F]{4} ){15}[0-9A-F]{4}", screen.arming.web.fingerprint)
    assert not browser.run("return document.querySelector('#start').offsetParent")
    browser.press("#control summary")
    browser.press("#take")
    browser.wait(lambda: screen.arming.web.controller == "otto", "the window says who it is")
    browser.wait(lambda: not screen.model.state().fields_locked, "the robot is ready")
    screen.arming.arm(screen.model.state())
    browser.wait_for_text("A person at the robot allows remote control", "#control")
    browser.press("#start")
    browser.wait_for_text("Hands clear", "dialog")
    # The question covers the page, but not STOP.
    assert browser.text("dialog .stop-now") == "STOP"
    browser.press("dialog button.primary")
    site.wait_for_state("SURVEYING")
    screen.arming.touched()
    browser.wait_for_text("Nobody at the robot allows it now", "#control")
    browser.press("#pause")
    site.wait_for_state("PAUSED")
    assert not browser.find("#pause").is_enabled()
    screen.arming.arm(screen.model.state())
    browser.press("#pause")
    browser.press("dialog button.primary")
    site.wait_for_state("SURVEYING")
    _stop_over_a_bad_link(site)
    site.wait_for_state("STOPPED")
    log = max(site.robot.data.glob("*/log.jsonl"))

    def noted() -> Set[str]:
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        entries = [one["values"] for one in lines if one.get("kind") == "audit"]
        assert all((one["user"], one["role"]) == ("otto", "control") for one in entries)
        return {one["command"] for one in entries if one["address"]}

    browser.wait(lambda: {"start", "pause", "resume", "stop"} <= noted(), "the log has all")


def _stop_over_a_bad_link(site: Site) -> None:
    browser = site.browser
    browser.run(LOSE)
    browser.press("#pause")
    browser.press("#stop")
    browser.wait_for_text("STOP is not confirmed yet", ".said")
    browser.wait_for_text("STOP NOT CONFIRMED: use the power switch", "#stop-warning")
    assert len(set(browser.run(ALARM_WIDTHS))) == 1
    assert violations(browser) == []
    browser.run("window.losePause()")
    assert "STOP is not confirmed yet" in browser.text(".said")
    assert not browser.find("#pause").is_enabled()
    browser.run(SLEEP)
    browser.wait(lambda: browser.run("return window.streams") == 1, "a new stream after a sleep")
    browser.run("document.dispatchEvent(new Event('visibilitychange'))")
    assert browser.run("return window.streams") == 2
    browser.wait(lambda: not browser.run(IS_STALE), "it is live")
    assert "STOP is not confirmed yet" in browser.text(".said")
    # Loaded again, as by another language, the page sends the same STOP before all else.
    script = "Page.addScriptToEvaluateOnNewDocument", {"source": BAD_FROM_THE_START}
    bad = browser.driver.execute_cdp_cmd(*script)
    browser.open(f"{site.address}/")
    assert "Conectando con" in browser.text("#page")
    browser.wait_for_text("otto: STOP: the request was accepted", ".said")
    asked = ["/api/stop", "/api/me"]
    assert browser.run("return window.asked.slice(0, 4)") == asked * 2
    browser.wait(lambda: browser.text("#stop-warning") == "", "STOP is confirmed")
    browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", bad)


def _expect_own_words_and_requests(site: Site) -> None:
    browser = site.browser
    assert "{" not in browser.text() and not re.search(r"\b[a-z]+\.[a-z_]+\b", browser.text("nav"))
    assert not browser.errors()
    asked = [json.loads(one["message"])["message"] for one in browser.driver.get_log("performance")]
    addresses = {
        one["params"]["request"]["url"]
        for one in asked
        if one["method"] == "Network.requestWillBeSent"
    }
    assert addresses
    assert all(one.startswith((site.address, "data:")) for one in addresses), addresses


@pytest.mark.parametrize(
    "theme, language", [("sun", "en"), pytest.param("night", "es", marks=pytest.mark.release)]
)
def test_every_page_fits_every_screen_asks_nobody_else_and_keeps_the_rules_of_accessibility(
    site: Site, theme: str, language: str
) -> None:
    browser = site.browser
    if not any(site.robot.data.glob("*/survey.json")):
        assert _survey(site, 3).wait(90.0) == 0
    browser.open(f"{site.address}/")
    browser.run("localStorage.setItem('theme', arguments[0])", theme)
    browser.driver.delete_all_cookies()
    browser.open(f"{site.address}/")
    browser.find("form")
    found = {"login": violations(browser)}
    site.log_in("ada", language)
    # Before the login, the page has asked whether somebody is logged in.
    browser.errors()
    browser.driver.get_log("performance")
    for page in PAGES:
        site.show(page)
        browser.find("#page section > *")
        # These show records and technical details, which are English.
        if language == "es" and page != "service":
            assert not english_words([browser.text()]), page
        if page == "surveys":
            browser.press("#page .list button")
            browser.find("#page textarea")
        for width_px in sorted(HEIGHTS, reverse=True):
            browser.resize(width_px)
            browser.wait(
                lambda: browser.run("return document.documentElement.scrollWidth") <= width_px,  # noqa: B023
                f"{page} fits {width_px} px",
            )
            browser.keep_picture(f"web_{page}_{width_px}_{language}")

        def keeps_them() -> bool:
            found[page] = violations(browser)  # noqa: B023
            return not found[page]  # noqa: B023

        # A label that needs the first answer of the page is empty until then.
        with contextlib.suppress(AssertionError):
            browser.wait(keeps_them, page)
    browser.run("localStorage.removeItem('theme')")
    assert {name: one for name, one in found.items() if one} == {}
    _expect_own_words_and_requests(site)


@pytest.mark.parametrize("pages", [("now",), pytest.param(PAGES[1:], marks=pytest.mark.release)])
def test_every_control_is_reached_by_tab_and_stop_by_the_keyboard(
    site: Site, pages: Sequence[str]
) -> None:
    browser = site.browser
    site.log_in("ada")
    browser.resize(800)
    for page in pages:
        site.show(page)
        browser.find("#page section > *")
        browser.wait(
            lambda: tab_reaches_all(browser),
            f"Tab reaches every control of {page} in its order",
        )
    press_by_keyboard(browser, "stop")
    browser.wait_for_text("ada: STOP: no survey was stopped. The axes were asked", "#top")


def test_what_is_old_is_said_to_be_old_and_becomes_true_again_by_itself(site: Site) -> None:
    browser = site.browser
    site.log_in("vera")
    browser.resize(800)
    process, watchdog = (site.robot.processes()[one] for one in (WEB, WATCHDOG))
    with contextlib.ExitStack() as stack:
        for one in (watchdog, process):  # which would end the other one after 10 s
            stack.callback(one.resume)
            one.suspend()
        browser.press("#stop")
        browser.wait_for_text("NO CONNECTION", "#top")
        assert browser.run(IS_STALE)
        browser.run("dispatchEvent(new PageTransitionEvent('pageshow', { persisted: true }))")
        assert "Connecting" in browser.text("#top")
        browser.wait_for_text("it is unknown whether it arrived", "#top")
        process.resume()
        browser.wait(lambda: not browser.run(IS_STALE), "it is live")
    browser.wait_for_text("vera: STOP: ", "#top")
    # Whoever opens the page later does not take it for what happens now.
    browser.open(f"{site.address}/")
    browser.find("#state")
    assert browser.text(".said") == ""


def test_who_is_in_control_and_a_stop_that_is_not_confirmed_are_in_sight(site: Site) -> None:
    browser = site.browser
    site.log_in("otto")
    browser.resize(360)
    browser.press("#control summary")
    browser.press("#take")
    browser.wait_for_text("You are in control", "#control")
    browser.run("document.querySelector('#release').focus()")
    # The button keeps the focus while what is beside it changes.
    browser.wait(lambda: browser.run("return document.activeElement.id") == "release", "it has it")
    browser.run(MOVES)
    browser.wait_for_text("ana is in control", "#control")
    for page in ("now", "map"):
        site.show(page)
        assert browser.text("body").count("X axis: MOVES") == 1
        assert "MOTORS" in browser.text("#top")
        assert violations(browser) == []
        browser.keep_picture(f"web_stop_warning_{page}_360")
    browser.run(DIALOG)
    browser.wait_for_text("X axis: MOVES", "dialog")
    assert len(set(browser.run(ALARM_WIDTHS))) == 1
    browser.run("document.querySelector('dialog').remove()")
    browser.wait_for_text("X axis: MOVES", "#top")
    browser.resize(800)


def test_stop_waits_for_no_connection_that_the_ground_holds(site: Site) -> None:
    browser = site.browser
    site.log_in("ada")
    site.show("map")
    browser.run(SLOW_GROUND)
    browser.wait(lambda: browser.run("return window.open") == 1, "the ground is asked for")
    depth = "document.querySelector('#page input[type=range]')"
    browser.run(f"{depth}.dispatchEvent(new Event('input'))")
    browser.wait(lambda: browser.run("return window.asked") == 2, "it is asked for again")
    assert browser.run("return window.open") == 1
    browser.press("#stop")
    browser.wait_for_text("ada: STOP: ", ".said")
    assert browser.run("return window.openAtStop") == 0
    assert browser.text("#alerts") == ""


def test_login_says_why_it_is_asked_for_and_what_was_not_carried_out(site: Site) -> None:
    browser = site.browser
    site.log_in("vera")
    browser.resize(360)
    browser.driver.delete_all_cookies()
    browser.press("#stop")
    browser.wait_for_text("STOP was NOT carried out", "form")
    assert "STOP NOT CONFIRMED: use the power switch" in browser.text("#stop-warning")
    assert len(set(browser.run(ALARM_WIDTHS))) == 1
    assert violations(browser) == []
    browser.keep_picture("web_login_stop_360")
    browser.resize(800)
    site.fill_in("vera")
    browser.wait_for_text("vera: STOP: no survey was stopped", ".said")
    assert browser.text("#stop-warning") == ""
    browser.driver.delete_all_cookies()
    browser.run("dispatchEvent(new PageTransitionEvent('pageshow', { persisted: true }))")
    browser.wait_for_text("You are no longer logged in: log in again.", "form")
    assert "STOP" not in browser.text("form")
