"""What a person enters about a survey: what was found at a place, and what its soil is."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import JobState
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.plan.fields import Keys
from gpr20_operator.words import entered_number, number_from_text
from gpr20_survey.plan.markers import MAX_DEPTH_MM, What
from gpr20_survey.radar import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY, Soils
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.look.translation import sentence_text, shown_number, shown_text
from gpr20_user_interface.pages.result_sheets import LONGEST_NAME, ResultSheet
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.keys import Judge, Pad
from gpr20_user_interface.widgets.widgets import new_button, offer, say

NONE = "—"
PERMITTIVITIES = Message(
    "{lowest:g} to {highest:g}", lowest=MIN_PERMITTIVITY, highest=LARGEST_PERMITTIVITY
)
DEPTHS = Message("0 to {deepest:g} mm; empty: not known", deepest=MAX_DEPTH_MM)


class PlaceSheet(ResultSheet):
    """One place: why it is on the list, and what to do; a hold stores what was found there.

    Args:
        window: The window that it covers.
        result: The result.
        operator: Returns who operates the robot now.
    """

    # A Candidate.
    finer_wanted = pyqtSignal(object)
    show_wanted = pyqtSignal(object)

    def __init__(self, window: QWidget, result: SurveyResult, operator: Callable[[], str]) -> None:
        super().__init__(window, result)
        self._operator = operator
        self._what: Optional[What] = None
        self._depth, self._who = "", ""
        # What was last sent to be stored.
        self._sent: object = None
        self.pad = Pad(window)
        self.whats: Dict[What, QPushButton] = {
            one: self.choice(partial(self._choose, one)) for one in What
        }
        self.deep, self.who = new_button(self._on_depth), new_button(self._on_who)
        self.store = HoldButton()
        self.store.held.connect(self._on_store)
        self.finer = new_button(lambda: self._leave(self.finer_wanted))
        self.view = new_button(lambda: self._leave(self.show_wanted), Message("Show in\nGround"))
        self.add_text()
        self.add_row(*self.whats.values())
        self.add_row(self.deep, self.who, self.store)
        self.add_end(self.finer, self.view)

    def ask(self, place: Candidate) -> None:
        """Open for a place."""
        record = self.result.record
        self._what, self._depth = None, ""
        self._who = self._operator() or (record.operator if record is not None else "")
        self.result.chosen = place
        self.result.noting.end()
        self.open_now()

    def show_now(self) -> None:
        """Show the place, and what is entered."""
        depth = shown_text(entered_number(self._depth)) or NONE
        self.deep.setText(f"{self.tr('Depth')}\n{depth} mm")
        self.who.setText(f"{self.tr('Who')}\n{self._who[:LONGEST_NAME] or NONE}")
        for what, key in self.whats.items():
            text = self.tr("Found:\n{what}").format(what=shown_text(texts.FINDS[what]))
            self.show_choice(key, text, what is self._what)
        place, record, noting = self.result.chosen, self.result.record, self.result.noting
        if place is None or record is None:
            self.hide()
            return
        known = self._what is not None and bool(self._who)
        missing = None if known and not noting.running else Message("Say what\nand who")
        offer(self.store, Message("Hold to\nstore"), missing)
        no_plan = None if record.grid.plan is not None else Message("Finer: not\nimported")
        offer(self.finer, Message("Measure\nfiner"), no_plan)
        self.title.setText(f"{place.number}   {shown_text(texts.whole_place(place))}")
        found, hidden = self.result.find_at(place), self.result.hiding.result
        entered = self._what, self._depth, self._who
        is_kept = self._what is None or (noting.state is JobState.DONE and entered == self._sent)
        say(self.close_button, Message("CLOSE") if is_kept else Message("Leave\nunsaved"))
        lines = [*([] if found is None else [texts.found_line(found)]), *texts.why_lines(place)]
        if hidden is not None:
            lines.append(hidden.at(place.x_m, place.y_m))
        self.show_job(noting, "\n".join(map(sentence_text, [*lines, texts.FROM_MARK])))

    def _leave(self, wanted: Any) -> None:
        self.hide()
        if self.result.chosen is not None:
            wanted.emit(self.result.chosen)

    def _choose(self, what: What) -> None:
        self._what = what
        self.show_now()

    def _on_depth(self) -> None:
        def take(text: str) -> None:
            self._depth = text.strip()
            self.show_now()

        judge = _judge(0.0, MAX_DEPTH_MM, DEPTHS)
        title, hint = self.tr("Depth"), shown_text(DEPTHS)
        self.pad.ask(take, title, hint, self._depth, judge, Keys.NUMBER)

    def _on_who(self) -> None:
        def take(text: str) -> None:
            self._who = text.strip()
            self.show_now()

        self.pad.ask(take, self.tr("Who"), "", self._who, lambda _text: "", Keys.LETTERS)

    def _on_store(self) -> None:
        place, what = self.result.chosen, self._what
        if place is not None and what is not None:
            depth_mm = number_from_text(self._depth) if self._depth else None
            try:
                self.result.note_found(place, what, depth_mm, self._who)
                self._sent = what, self._depth, self._who
            except InvalidValueError as error:
                self.result.noting.refuse(error.message)
            self.show_now()


class SoilSheet(ResultSheet):
    """Stores another permittivity by a hold; the image and the list are computed again."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self._value: Optional[float] = None
        self.pad = Pad(window)
        known = {one: one.value.permittivity for one in Soils}
        self.soils = {one: self.choice(partial(self._choose, known[one])) for one in Soils}
        self.unknown = self.choice(partial(self._choose, None))
        self.other = new_button(self._on_other)
        self.use = HoldButton()
        self.use.held.connect(self._on_use)
        say(self.title, Message("Soil of this survey"))
        self.add_row(*self.soils.values())
        self.add_row(self.unknown, self.other)
        self.add_text()
        self.add_end(self.use)

    def ask(self) -> None:
        """Open with the present value."""
        self._value = self.result.permittivity
        self.open_now()

    def show_now(self) -> None:
        """Show what is chosen."""
        for soil, key in self.soils.items():
            value = soil.value.permittivity
            self.show_choice(
                key, f"{shown_text(soil.value.name)}\n{shown_number(value)}", value == self._value
            )
        self.show_choice(self.unknown, self.tr("Not known"), self._value is None)
        other, known = self._value, [one.value.permittivity for one in Soils]
        number = "" if other is None or other in known else f"\n{shown_number(other)}"
        self.other.setText(self.tr("Other value") + number)
        used = self._value == self.result.permittivity
        offer(self.use, Message("Hold to use it"), Message("It is used now") if used else None)
        self.text.setText(
            self.tr(
                "Depths, places, hiding places and reports use this permittivity. The search "
                "begins again with it."
            )
        )

    def _choose(self, value: Optional[float]) -> None:
        self._value = value
        self.show_now()

    def _on_other(self) -> None:
        self.pad.ask(
            lambda text: self._choose(number_from_text(text)),
            *(self.tr("Permittivity"), shown_text(PERMITTIVITIES)),
            "" if self._value is None else f"{self._value:g}",
            _judge(MIN_PERMITTIVITY, LARGEST_PERMITTIVITY, PERMITTIVITIES, may_be_empty=False),
            Keys.NUMBER,
        )

    def _on_use(self) -> None:
        self.hide()
        self.result.set_permittivity(self._value)


def _judge(lowest: float, highest: float, allowed: Message, may_be_empty: bool = True) -> Judge:
    def judge(text: str) -> str:
        if not text.strip() and may_be_empty:
            return ""
        try:
            right = lowest <= number_from_text(text) <= highest
        except InvalidValueError:
            right = False
        return "" if right else shown_text(allowed)

    return judge
