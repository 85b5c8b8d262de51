"""Sleeves, rain and children: random touches start, resume, home and delete nothing.

`GPR20_TOUCHES` sets their number, `GPR20_TOUCH_SEED` what is drawn.
"""

import os
import random
import sys

from PyQt5.QtCore import QPoint
from PyQt5.QtWidgets import QAbstractButton, QApplication
from run_seed import draws
from view_kit import FOLDER, PAST, description, past_survey, snapshot
from window_helpers import AFTER_S, Finger, place_of, show, take_list, wishes

from gpr20_common.message import verbatim
from gpr20_operator.jobs.pictures import StoredSurvey
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Answer, Progress, Request
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_operator.robot.remote_control import Arming, WebStatusReported
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.widgets.widgets import Overlay

TOUCHES = int(os.environ.get("GPR20_TOUCHES", draws(1000)))
SEED = int(os.environ.get("GPR20_TOUCH_SEED", "0"))
PERIOD_S = 0.05
# What may be asked for: all of it stops the robot or moves nothing.
HARMLESS = {"stop", "pause"}
# Of SERVICE: whether its tab is looked at, and what CHECK ALL asks for.
LOOKED = {
    *(("watch", True), ("watch", False), ("examine", False), ("examine", True)),
    *("height", "analyzer"),
}
IDENTITY = "Anritsu,MS2026C"


class Field:
    """A window in the field, where anything may happen while something touches it.

    Its rules: nothing starts, resumes, homes or changes records without a hold; STOP always works.
    """

    def __init__(self, opened, clock):
        self.random, self.arming = random.Random(SEED), Arming(clock)
        self.window = opened(arming=self.arming)
        self.opened, self.answered, self.acts = set(), 0, []
        take_list(self.window, (past_survey(),))
        self.window.on_event(WebStatusReported("192.168.1.10", 8443, "AB12 CD34", 3, "Ana"))
        self.overlays = self.window.findChildren(Overlay)
        self.buttons = self.window.findChildren(QAbstractButton)
        self.finger = Finger(self.window, clock)
        self.say(SurveyState.IDLE)

    def say(self, code, alive=True):
        """Let the robot say in which state it is, or be silent from then on."""
        progress = Progress("id", 33.0, 242, 80, 1500.0)
        show(self.window, snapshot(code, alive, progress=progress))

    def happen(self):
        """Let the robot or another client do something; each in its turn, and which is drawn."""
        if not self.acts:
            self.acts = [*self.deeds(), *[self.say_anything] * 4, *[self.unlock] * 2]
            self.random.shuffle(self.acts)
        self.acts.pop()()

    def say_anything(self):
        self.say(self.random.choice(list(SurveyState)), self.random.random() < 0.9)

    def unlock(self):
        self.window.touch_binding.set_locked(False)

    def deeds(self):
        """Return what may happen beside a new state."""
        window = self.window
        notice = refusal_notice(Refused.PAUSE, verbatim("the reason"))
        refusal = Answer(Request.RESUME, False, verbatim("another one"), "", IDENTITY)
        read = StoredSurvey(description(survey_id=PAST), tuple(range(40)))
        return (
            lambda: window.show_tab(self.random.choice(list(TabName))),
            lambda: window.past.choose(window.traces.past.surveys[0]),
            lambda: self.mean(SurveyState.IDLE, window.control.start, self.show_plan),
            lambda: self.mean(SurveyState.PAUSED, window.top_bar.pause),
            lambda: window.notice.show_notice(notice),
            lambda: window.alerts.take_refusal(refusal),
            lambda: (window.traces.open_survey(FOLDER), window.traces.opening._done(read)),
            lambda: (self.clear(), window.remote.open()),
            lambda: window.annotation.show_annotation(FOLDER, Annotation("Ana", name="field 3")),
        )

    def clear(self):
        """Let nothing be in the way of somebody who means it."""
        for overlay in self.overlays:
            overlay.hide()
        self.unlock()

    def mean(self, code, button, prepare=lambda: None):
        """Touch a button that random touches seldom find where it acts."""
        self.clear()
        self.say(code)
        prepare()
        QApplication.processEvents()
        self.finger.wait(AFTER_S)
        self.finger.tap(button)

    def show_plan(self):
        self.window.control.show_parameters(default_parameters())
        self.window.show_tab(TabName.SURVEY)
        self.window.survey_tab.show_plan(self.window.survey.snapshot)

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
        self.answer_stop()

    def place(self):
        """Return anywhere on the screen, or on one of the buttons."""
        window = self.window
        anywhere = QPoint(
            self.random.randrange(window.width()), self.random.randrange(window.height())
        )
        if self.random.random() < 0.4:
            return anywhere
        seen = [one for one in self.buttons if one.isVisible()]
        self.random.shuffle(seen)
        for one in seen:
            place = place_of(window, one).center()
            if window.childAt(place) is one:
                return place
        return anywhere

    def press_stop(self):
        """Press STOP, which acts on the press whatever has just happened."""
        stop, before = self.window.top_bar.stop, wishes(self.window).count("stop")
        self.finger.press(stop)
        assert wishes(self.window).count("stop") == before + 1
        self.finger.release(stop)
        self.answer_stop()

    def answer_stop(self):
        """Answer each STOP: whether one is late is a matter of the computer's time."""
        stops = wishes(self.window).count("stop")
        if stops > self.answered:
            self.window.on_event(Answer(Request.STOP, True, verbatim("stopping")))
        self.answered = stops

    def check_wishes(self):
        assert set(wishes(self.window)) <= HARMLESS and not self.arming.armed
        changed = {fields.get("kind") for _name, _ticket, fields in self.window.node.asked}
        assert not changed & {Kind.MARKER_REMOVED, Kind.ANNOTATION}
        assert set(self.window.tools.asked) <= LOOKED


def test_random_touches_neither_start_nor_resume_nor_home_nor_change(opened, clock, monkeypatch):
    raised = []
    # What a slot of Qt raises ends the real window.
    monkeypatch.setattr(sys, "excepthook", lambda *error: raised.append(error))
    field = Field(opened, clock)
    window = field.window
    for number in range(TOUCHES):
        try:
            if number % 5 == 0:
                field.happen()
                # As its timer does 5 times a second.
                window.refresh()
                field.opened |= {one for one in field.overlays if one.isVisible()}
            field.touch()
            field.check_wishes()
            if number % 20 == 0:
                field.press_stop()
        except AssertionError as error:
            raise AssertionError(f"touch {number} of seed {SEED}") from error
        assert not raised, f"touch {number} of seed {SEED}"
    # The touches were at the buttons that matter.
    asking = {window.start_sheet, window.remote}
    assert asking <= field.opened
