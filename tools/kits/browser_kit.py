"""Debian's Chromium without a screen, and what a person does with it."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any, Callable, List

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException, WebDriverException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement

CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"
LIMIT_S = 90.0
PAUSE_S = 0.05
# As tall as a telephone of that width, a tablet, a desktop.
HEIGHTS = {360: 740, 800: 600, 1440: 900}


class Browser:
    """One window of Chromium; it accepts the certificate that the installation made.

    Args:
        keeps_logs: Whether it notes every request and error, which costs it processor time.
    """

    def __init__(self, keeps_logs: bool = True) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for one in ("headless=new", "no-sandbox", "disable-dev-shm-usage", "disable-gpu"):
            options.add_argument(f"--{one}")
        options.accept_insecure_certs = True
        if keeps_logs:
            options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(DRIVER))
        self.driver.set_script_timeout(LIMIT_S)
        # Called again and again while somebody waits for the page.
        self.meanwhile: Callable[[], None] = lambda: None

    def close(self) -> None:
        """End Chromium."""
        self.driver.quit()

    def open(self, address: str) -> None:
        """Open a page."""
        self.driver.get(address)

    def run(self, script: str, *arguments: Any) -> Any:
        """Run a script in the page."""
        return self.driver.execute_script(script, *arguments)

    def find(self, selector: str) -> WebElement:
        """Return an element that can be seen, once it is there."""
        found: List[WebElement] = []

        def seen() -> bool:
            found[:] = self.driver.find_elements(By.CSS_SELECTOR, selector)[:1]
            return bool(found) and found[0].is_displayed()

        self.wait(seen, f"{selector} is seen")
        return found[0]

    def text(self, selector: str = "body") -> str:
        """Return the text that a person reads in an element."""
        return str(self.run("return document.querySelector(arguments[0])?.innerText", selector))

    def press(self, selector: str) -> None:
        """Press a button once it can be pressed."""

        def pressed() -> bool:
            button = self.find(selector)
            if not button.is_enabled():
                return False
            # Not below what stays at the edge of the screen.
            self.run("arguments[0].scrollIntoView({ block: 'center' })", button)
            button.click()
            return True

        self.wait(pressed, f"{selector} is pressed")

    def write(self, selector: str, text: str) -> None:
        """Write into a field, in place of what is there."""
        field = self.find(selector)
        field.clear()
        field.send_keys(text)

    def wait(self, condition: Callable[[], Any], what: str, limit_s: float = LIMIT_S) -> None:
        """Return when a condition holds.

        Raises:
            AssertionError: It does not in time.
        """
        deadline_s = time.monotonic() + limit_s
        self.meanwhile()
        while not self._holds(condition):
            if time.monotonic() > deadline_s:
                raise AssertionError(f"not within {limit_s:g} s: {what}\n{self.text()}")
            time.sleep(PAUSE_S)
            self.meanwhile()

    @staticmethod
    def _holds(condition: Callable[[], Any]) -> bool:
        try:
            return bool(condition())
        except (StaleElementReferenceException, WebDriverException):
            # The page was drawn again meanwhile.
            return False

    def wait_for_text(self, text: str, selector: str = "body") -> None:
        """Return when an element shows a text."""
        self.wait(lambda: text in self.text(selector), f"{text!r} in {selector}")

    def resize(self, width_px: int) -> None:
        """Become a telephone, a tablet or a desktop."""
        metrics = {"width": width_px, "height": HEIGHTS[width_px]}
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {**metrics, "deviceScaleFactor": 1, "mobile": width_px < 800},
        )

    def keep_picture(self, name: str) -> None:
        """Write what is on the screen where an engineer can look at it, if $GPR20_PICTURES is."""
        folder = os.environ.get("GPR20_PICTURES", "")
        if folder:
            self.driver.save_screenshot(str(Path(folder) / f"{name}.png"))

    def errors(self) -> List[str]:
        """Return what the browser complained of since the last call."""
        found = self.driver.get_log("browser")
        return [one["message"] for one in found if one["level"] == "SEVERE"]
