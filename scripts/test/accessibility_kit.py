"""Whether everybody can use a page: WCAG 2.1 A and AA by axe-core, and the keyboard."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import List

from browser_kit import Browser
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

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
