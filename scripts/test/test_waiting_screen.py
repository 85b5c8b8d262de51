"""What the robot's screen says before there is a window: deploy/waiting_screen.py."""

from __future__ import annotations

import sys

from user_shell import ROOT, imported, printed_by

from gpr20_common.catalogue import Language

waiting_screen = imported("waiting_screen")
TWO = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2"}
MASTER = {"ROS_MASTER_URI": "http://127.0.0.1:9"}


def missing(environment, own=True, master=False):
    """Return what is missing, in English, and the addresses that were looked for."""
    looked = []
    found = waiting_screen.missing(
        {**MASTER, **environment},
        lambda address: looked.append(address) or own,
        lambda uri: looked.append(uri) or master,
    )
    return str(found), looked


def test_what_is_missing_is_named_the_link_first_then_the_pc():
    assert missing(TWO, master=True) == ("None", ["10.20.0.1", "http://127.0.0.1:9"])
    assert "does not have the address 10.20.0.1" in missing(TWO, own=False, master=True)[0]
    assert "Waiting for the PC 10.20.0.2" in missing(TWO)[0]
    # An address that was exported counts, and one that was set by itself does not.
    assert "PC" in missing({**TWO, "ROS_IP": "127.0.0.3"}, own=False)[0]
    own = {"ROS_IP": "127.0.0.1", "GPR20_SET_ROS_IP": "127.0.0.1"}
    assert "the address 10.20.0.1" in missing({**TWO, **own}, own=False)[0]


def test_it_has_the_language_of_the_window(tmp_path):
    for arguments, remembered, language in (
        ("", "language: es", Language.SPANISH),
        ("_language:=es", "", Language.SPANISH),
        ("_language:=auto", "language: es", Language.SPANISH),
        ("_language:=xx", "", Language.ENGLISH),
    ):
        (tmp_path / "window.yaml").write_text(remembered)
        own = {"GPR20_WINDOW_ARGUMENTS": arguments}
        assert waiting_screen.language_of(own, tmp_path / "window.yaml") == language


SHOW = """
import sys
from PyQt5.QtWidgets import QApplication
import waiting_screen
answers = iter([waiting_screen.Message("Waiting for the PC {address}. Switch it on, and check "
    "the cable.", address="10.20.0.2"), None])
waiting_screen.POLL_S = 0.5
application = QApplication(sys.argv[:1])
screen = waiting_screen.WaitingScreen(lambda: next(answers), waiting_screen.Language.SPANISH)
screen.show()
application.exec_()
print(screen.label.text())
"""


def test_it_shows_the_sentence_and_ends_when_nothing_is_missing():
    show = (sys.executable, "-c", SHOW)
    said = printed_by(*show, folder=ROOT / "deploy", QT_QPA_PLATFORM="offscreen")
    assert said.splitlines()[-1] == "Esperando al PC 10.20.0.2. Enciéndalo y revise el cable."
