"""The screen stays on while the window is open, and is then as it was."""

import subprocess

import pytest

from gpr20_user_interface.low.screen_saver import ScreenSaver

PRINTED = """Screen Saver:
  prefer blanking:  yes    allow exposures:  yes
  timeout:  {timeout}    cycle:  {cycle}
Colors:
  default colormap:  0x20    BlackPixel:  0x0    WhitePixel:  0xffffff
DPMS (Display Power Management Signaling):
  Standby: 600    Suspend: 600    Off: 600
  DPMS is {power}
  Monitor is On
"""


class Screen:
    """Remembers its commands; answers like xset."""

    def __init__(self, printed="", error=None):
        self.printed, self.error = printed, error
        self.commands = []

    def run(self, command):
        if self.error is not None:
            raise self.error
        self.commands.append(" ".join(command))
        return self.printed


@pytest.mark.parametrize(
    "power, restored", [("Enabled", "xset s 600 300 +dpms"), ("Disabled", "xset s 600 300")]
)
def test_what_was_set_before_is_restored(power, restored):
    screen = Screen(PRINTED.format(timeout=600, cycle=300, power=power))
    saver = ScreenSaver(screen.run)
    assert saver.switch_off() is None
    assert screen.commands == ["xset q", "xset s off -dpms"]
    assert saver.restore() is None
    assert screen.commands[2:] == [restored]
    saver.restore()
    assert len(screen.commands) == 3


def test_a_screen_without_power_saving_keeps_its_times():
    screen = Screen("Screen Saver:\n  timeout:  0    cycle:  0\nServer does not have DPMS\n")
    saver = ScreenSaver(screen.run)
    saver.switch_off()
    saver.restore()
    assert screen.commands[-1] == "xset s 0 0"


@pytest.mark.parametrize(
    "error, reason",
    [
        (FileNotFoundError("xset"), "xset is not installed (Debian package x11-xserver-utils)"),
        (subprocess.CalledProcessError(1, ["xset", "q"]), "returned non-zero exit status 1"),
        (subprocess.TimeoutExpired(["xset", "q"], 3.0), "timed out after 3.0 seconds"),
    ],
)
def test_a_screen_that_cannot_be_set_is_a_note_and_nothing_is_restored(error, reason):
    screen = Screen(error=error)
    saver = ScreenSaver(screen.run)
    assert reason in saver.switch_off()
    screen.error = None
    assert saver.restore() is None
    assert screen.commands == []
