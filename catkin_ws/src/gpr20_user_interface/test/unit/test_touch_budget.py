"""How many touches a survey takes, counted on a window without ROS."""

import random

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import hold_to_start, show

from gpr20_common.message import verbatim
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.events import Answer, Request, RobotDefaults, Site
from gpr20_survey.plan.survey_state import SurveyState

FROM_MEMORY, FROM_FACTORY = 10, 20
NOTHING_CONFIGURED = RobotDefaults("", Site())
PREFIXES = ("192.168.", "10.", "172.")


class Finger:
    """Touches what is seen, and counts."""

    def __init__(self):
        self.touches = 0

    def touch(self, widget):
        assert widget.isVisible() and widget.isEnabled()
        self.touches += 1
        QTest.mouseClick(widget, Qt.LeftButton)

    def start(self, window):
        """START opens a summary; holding its button begins the survey."""
        self.touch(window.control.start)
        self.touches += 1
        hold_to_start(window)


def begun(window):
    window.control.begin()
    show(window, snapshot(SurveyState.IDLE, defaults=NOTHING_CONFIGURED))
    return window


def plan(window, finger, address):
    """Enter an address and an area of 300 x 300 mm with a finger."""
    control, values = window.control, window.values
    finger.touch(control.tiles[Tile.VNA])
    prefix = next((one for one in PREFIXES if address.startswith(one)), "")
    for key in [*([prefix] if prefix else []), *address[len(prefix) :]]:
        finger.touch(next(one for one in values.keys.keys if one.property("character") == key))
    finger.touch(values.done)
    finger.touch(control.tiles[Tile.AREA])
    finger.touch(values.presets[1])
    finger.touch(values.done)
    finger.start(window)


def test_an_address_and_an_area_from_factory_values(opened):
    draw = random.Random(1)
    networks = (["192", "168"], ["10"], ["172", str(draw.randint(16, 31))])
    for network in networks:
        last = [str(draw.randint(0, 255)) for _ in range(4 - len(network))]
        address = ".".join(network + last)
        window, finger = begun(opened()), Finger()
        plan(window, finger, address)
        (started,) = window.survey.asked
        assert started.vna_address == address
        assert (started.x_start_mm, started.x_stop_mm) == (175.0, 475.0)
        assert (started.y_start_mm, started.y_stop_mm) == (250.0, 550.0)
        assert finger.touches <= FROM_FACTORY, address


def test_what_was_measured_last_takes_fewer_touches_as_it_was_or_with_changes(opened):
    window, finger = begun(opened()), Finger()
    plan(window, finger, "192.168.1.10")
    before = window.survey.asked[0]
    window.on_event(Answer(Request.START, True, verbatim("Survey started"), "id"))
    window.control.form.set_text("x_stop_mm", "200")
    window.refresh()
    assert window.plans.wait(30.0)
    # The plan that is not finished, and the last area.
    window, finger = begun(opened()), Finger()
    finger.touch(window.control.tiles[Tile.AREA])
    finger.touch(window.values.presets[3])
    finger.touch(window.values.done)
    finger.start(window)
    assert window.survey.asked == [before] and finger.touches <= FROM_MEMORY
    for tile, preset in ((Tile.SPACING, 1), (Tile.SOIL, 1)):
        finger.touch(window.control.tiles[tile])
        finger.touch(window.values.presets[preset])
        finger.touch(window.values.done)
    finger.start(window)
    assert window.survey.asked[1].x_points == 31
    assert finger.touches <= 2 * FROM_MEMORY
