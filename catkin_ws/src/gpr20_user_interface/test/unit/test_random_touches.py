"""Sleeves, rain and children: random touches start, resume, home and delete nothing.

`GPR20_TOUCHES` sets their number, `GPR20_SEEDS` the number of seeds.
"""

import os
import random
import sys

import pytest
from fake_clock import FakeClock
from finger import Finger, place_of
from PyQt5.QtCore import QPoint
from PyQt5.QtWidgets import QAbstractButton
from view_kit import description, snapshot
from window_helpers import Storage, close, new_window, show, wishes

from gpr20_common.catalogue import Language
from gpr20_common.message import verbatim
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.mid.events import Progress
from gpr20_user_interface.mid.notices import Refused, refusal_notice
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.trace_events import SurveyRead, SurveysListed
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.translation import Languages

TOUCHES = int(os.environ.get("GPR20_TOUCHES", "10000"))
SEEDS = int(os.environ.get("GPR20_SEEDS", "1"))
PERIOD_S = 0.05
PAST = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
FOLDER = "20261121T051000_7c9e6679"
KEPT = {f"field {number}.yaml" for number in range(3)}
# What may be asked for: all of it stops the robot or moves nothing.
HARMLESS = {"stop", "pause", "pause replay"}
# Of SERVICE: whether its tab is looked at, and what CHECK ALL asks for.
LOOKED = {
    *(("watch", True), ("watch", False), ("examine", False), ("examine", True)),
    *("height", "analyzer"),
}
STATES = (
    *(SurveyState.IDLE, SurveyState.CONFIGURED, SurveyState.SURVEYING, SurveyState.PAUSED),
    *(SurveyState.STOPPED, SurveyState.FAILED, SurveyState.FINISHED),
)


class Field:
    """A window in the field, where anything may happen while something touches it."""

    def __init__(self, application, folder, seed):
        self.random = random.Random(seed)
        self.window = new_window(
            Languages(application, Language.ENGLISH),
            storage=Storage(),
            profiles=folder,
            clock=FakeClock(),
        )
        self.opened = set()
        for name in sorted(KEPT):
            self.window.profiles.show_profiles(default_parameters())
            self.window.profiles._save(name[: -len(".yaml")])
        self.window.profiles.hide()
        self.window.show()
        self.window.on_event(SurveysListed("", (unfinished(),), False))
        self.overlays = self.window.findChildren(Overlay)
        self.buttons = self.window.findChildren(QAbstractButton)
        self.finger = Finger(self.window, self.window.clock)

    def happen(self):
        """Let the robot or another client do something."""
        window, chance = self.window, self.random.random()
        code = self.random.choice(STATES)
        if chance < 0.3:
            show(window, snapshot(code, progress=Progress("id", 33.0, 242, 80, 1500.0)))
        elif chance < 0.4:
            window.show_tab(self.random.choice(list(TabName)))
        elif chance < 0.5:
            window.past.table.selectRow(0)
        elif chance < 0.6 and not window.survey.snapshot.fields_locked:
            window.profiles.show_profiles(default_parameters())
            window.profiles.names.setCurrentRow(self.random.randrange(3))
        elif chance < 0.63:
            window.notice.show_notice(refusal_notice(Refused.STOP, verbatim("the reason")))
        elif chance < 0.66:
            window.survey_binding._ask_about_analyzer(verbatim("another one"), "Anritsu,MS2026C")
        elif chance < 0.7:
            window.on_event(SurveyRead(FOLDER, description(survey_id=PAST), tuple(range(40))))
        elif chance < 0.95:
            window.touch_binding.set_locked(False)
        else:
            window.draw()

    def touch(self):
        """Touch somewhere for a moment, or wipe over the screen."""
        start = self.place()
        self.finger.press(start)
        if self.random.random() < 0.3:
            end = self.place()
            for part in (0.3, 0.7, 1.0):
                self.finger.move(start + (end - start) * part)
            start = end
        self.finger.wait(0.6 * PERIOD_S)
        self.finger.release(start)
        self.finger.wait(0.4 * PERIOD_S)

    def place(self):
        """Return anywhere on the screen, or on one of the buttons."""
        window = self.window
        anywhere = QPoint(
            self.random.randrange(window.width()), self.random.randrange(window.height())
        )
        if self.random.random() < 0.4:
            return anywhere
        buttons = [one for one in self.buttons if one.isVisible()]
        place = place_of(window, self.random.choice(buttons)).center()
        return place if window.rect().contains(place) else anywhere

    def note_opened(self):
        self.opened |= {overlay for overlay in self.overlays if overlay.isVisible()}


def unfinished():
    return SurveySummary(
        *(FOLDER, PAST, "2026-11-21T05:10:00.000000+00:00", "stopped", 7, 40),
        *(verbatim("INCOMPLETE"), False, True, None),
    )


@pytest.mark.parametrize("seed", range(SEEDS))
def test_random_touches_neither_start_nor_resume_nor_home_nor_delete(
    application, tmp_path, seed, monkeypatch
):
    raised = []
    # What a slot of Qt raises ends the real window.
    monkeypatch.setattr(sys, "excepthook", lambda *error: raised.append(error))
    field = Field(application, tmp_path, seed)
    window = field.window
    for number in range(TOUCHES):
        if number % 10 == 0:
            field.happen()
        field.touch()
        field.note_opened()
        assert not raised, f"touch {number} of seed {seed}"
        assert set(wishes(window)) <= HARMLESS, f"touch {number} of seed {seed}"
        removed = [one for one in window.traces.source.asked if one[0] == "remove marker"]
        assert not removed, f"touch {number} of seed {seed}"
        assert set(window.tools.asked) <= LOOKED, f"touch {number} of seed {seed}"
    assert {one.name for one in tmp_path.iterdir()} >= KEPT
    # The touches were at the buttons that matter.
    assert {window.start_sheet, window.profiles.confirm, window.question} <= field.opened
    assert "stop" in wishes(window)
    close(window)
