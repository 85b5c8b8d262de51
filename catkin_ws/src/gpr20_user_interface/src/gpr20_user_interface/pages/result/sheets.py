"""What opens over the result: one place, what was found there, the soil, hiding places."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Sequence

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Job, JobState
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.plan.fields import Keys
from gpr20_operator.robot.condition import first_step
from gpr20_operator.words import entered_number, number_from_text
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY, Soils
from gpr20_survey.results.candidates import NO_CLEARANCE, Candidate
from gpr20_survey.results.found import MAX_DEPTH_MM, What
from gpr20_survey.results.hidden_target import Targets
from gpr20_survey.results.hiding_map import MM_PER_M, ONLY_THIS
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import sentence_text, shown_number, shown_text
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.keys import Judge, Pad
from gpr20_user_interface.widgets.labels import PulledText, SurveyBand
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

LONGEST_NAME = 12
NONE = "—"
PERMITTIVITIES = Message(
    "{lowest:g} to {highest:g}", lowest=MIN_PERMITTIVITY, highest=LARGEST_PERMITTIVITY
)
DEPTHS = Message("0 to {deepest:g} mm; empty: not known", deepest=MAX_DEPTH_MM)


def with_remedy(problem: Message) -> str:
    """Return a problem, and what to do first."""
    return "\n".join(
        sentence_text(one) for one in (problem, first_step(problem)) if one is not None
    )


class ResultSheet(Overlay):
    """A title, rows of keys, a text, a bar while something runs, and keys below.

    Args:
        window: The window that it covers.
        result: The result.
    """

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window)
        self.result = result
        self._drawn: object = None
        self.title, self.text, self.progress = QLabel(), PulledText(), QProgressBar()
        self.title.setObjectName("title")
        self.progress.setRange(0, 0)  # it is not known how long it takes
        self.close_button = new_button(self.hide)
        self.no_clearance = QLabel()
        self.no_clearance.setObjectName("alarm")
        self.no_clearance.setWordWrap(True)
        self._rows: List[QHBoxLayout] = []
        self.band = SurveyBand()
        self._page = QVBoxLayout(self)
        self._page.addWidget(self.band)
        self._page.addWidget(self.title)

    def refresh(self) -> None:
        """Show what has changed, while it is open."""
        revision = self.result.revision
        if self.isVisible() and revision != self._drawn:
            self._drawn = revision
            self.band.show_band(texts.band(self.result))
            self.show_now()

    def show_now(self) -> None:
        """Show what is known now."""

    def open_now(self) -> None:
        """Open with what is known now."""
        self.band.show_band(texts.band(self.result))
        self.show_now()
        self.open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("CLOSE"))
        self.no_clearance.setText(shown_text(NO_CLEARANCE))
        self.show_now()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._page.setContentsMargins(2 * gap_px, gap_px, 2 * gap_px, gap_px)
        for layout in (self._page, *self._rows):
            layout.setSpacing(gap_px)

    def add_row(self, widgets: Sequence[QWidget]) -> None:
        """Add a row of keys."""
        row = QHBoxLayout()
        for widget in widgets:
            row.addWidget(widget, 1)
        self._rows.append(row)
        self._page.addLayout(row)

    def add_text(self, *keys: QWidget) -> None:
        """Add the text, the bar and the keys below them."""
        self._page.addWidget(self.text, 1)
        self._page.addWidget(self.progress)
        self.add_end(*keys)

    def add_end(self, *keys: QWidget) -> None:
        """Add the last keys, and what the list is not."""
        self.add_row([*keys, self.close_button])
        self._page.addWidget(self.no_clearance)

    def choice(self, act: Callable[[], None]) -> QPushButton:
        """Return a key that is chosen or not."""
        key = new_button(act)
        key.setCheckable(True)
        key.setObjectName("choice")
        return key

    def show_choice(self, key: QPushButton, text: str, chosen: bool) -> None:
        """Show whether a key is chosen, not by the colour alone."""
        key.setChecked(chosen)
        key.setText(f"\N{CHECK MARK} {text}" if chosen else text)

    def show_job(self, job: Job, rest: str) -> None:
        """Show how a job is going, or what its page says otherwise."""
        self.progress.setVisible(job.running)
        self.text.setText(rest if job.problem is None else with_remedy(job.problem))


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
        self._problem: Optional[Message] = None
        self.pad = Pad(window)
        self.whats: Dict[What, QPushButton] = {one: self._key(one) for one in What}
        self.deep, self.who = new_button(self._on_depth), new_button(self._on_who)
        self.store = HoldButton()
        self.store.held.connect(self._on_store)
        self.finer = new_button(lambda: self._leave(self.finer_wanted))
        self.view = new_button(lambda: self._leave(self.show_wanted))
        self._page.addWidget(self.text, 1)
        self.add_row(list(self.whats.values()))
        self.add_row([self.deep, self.who, self.store])
        self.add_end(self.finer, self.view)
        self.retranslate()

    def ask(self, place: Candidate) -> None:
        """Open for a place."""
        record = self.result.record
        self._what, self._depth, self._problem = None, "", None
        self._who = self._operator() or (record.operator if record is not None else "")
        self.result.chosen = place
        self.result.noting.end()
        self.open_now()

    def show_now(self) -> None:
        """Show the place, and what is entered."""
        self.finer.setText(self.tr("Measure\nfiner"))
        self.view.setText(self.tr("Show in\nGround"))
        depth = shown_text(entered_number(self._depth)) or NONE
        self.deep.setText(f"{self.tr('Depth')}\n{depth} mm")
        self.who.setText(f"{self.tr('Who')}\n{self._who[:LONGEST_NAME] or NONE}")
        self.store.setText(self.tr("Hold to\nstore"))
        for what, key in self.whats.items():
            text = self.tr("Found:\n{what}").format(what=shown_text(texts.FINDS[what]))
            self.show_choice(key, text, what is self._what)
        place, record, noting = self.result.chosen, self.result.record, self.result.noting
        if place is None or record is None:
            self.hide()
            return
        self.store.setEnabled(self._what is not None and bool(self._who) and not noting.running)
        self.finer.setEnabled(record.grid.plan is not None)
        self.title.setText(f"{place.number}   {shown_text(texts.whole_place(place))}")
        problem = self._problem or noting.problem
        lines = self._lines(place) if problem is None else [with_remedy(problem)]
        self.text.setText("\n".join(lines))

    def _lines(self, place: Candidate) -> List[str]:
        found, hidden = self.result.find_at(place), self.result.hiding.result
        lines = [*([] if found is None else [texts.found_line(found)]), *texts.why_lines(place)]
        if hidden is not None:
            lines.append(hidden.at(place.x_m, place.y_m))
        return [sentence_text(one) for one in [*lines, texts.FROM_MARK]]

    def _leave(self, wanted: Any) -> None:
        self.hide()
        if self.result.chosen is not None:
            wanted.emit(self.result.chosen)

    def _key(self, what: What) -> QPushButton:
        def act() -> None:
            self._what = what
            self.show_now()

        return self.choice(act)

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
        if self.result.chosen is None or self._what is None:
            return
        try:
            depth_mm = number_from_text(self._depth) if self._depth else None
            self.result.note_found(self.result.chosen, self._what, depth_mm, self._who)
            self._problem = None
        except InvalidValueError as error:
            self._problem = error.message
        self.show_now()


class SoilSheet(ResultSheet):
    """Changes the permittivity, and with it everything that is made with it, by a hold."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self._value: Optional[float] = None
        self.pad = Pad(window)
        self.soils = {one: self._key(one.value.permittivity) for one in Soils}
        self.unknown, self.other = self._key(None), new_button(self._on_other)
        self.use = HoldButton()
        self.use.held.connect(self._on_use)
        self.add_row(list(self.soils.values()))
        self.add_row([self.unknown, self.other])
        self.add_text(self.use)
        self.progress.hide()
        self.retranslate()

    def ask(self) -> None:
        """Open with the present value."""
        self._value = self.result.permittivity
        self.open_now()

    def show_now(self) -> None:
        """Show what is chosen."""
        self.title.setText(self.tr("Soil of this survey"))
        for soil, key in self.soils.items():
            value = soil.value.permittivity
            self.show_choice(
                key, f"{shown_text(soil.value.name)}\n{shown_number(value)}", value == self._value
            )
        self.show_choice(self.unknown, self.tr("Not known"), self._value is None)
        other, known = self._value, [one.value.permittivity for one in Soils]
        number = "" if other is None or other in known else f"\n{shown_number(other)}"
        self.other.setText(self.tr("Other value") + number)
        self.use.setText(self.tr("Hold to use it"))
        self.use.setEnabled(self._value != self.result.permittivity)
        self.text.setText(
            self.tr(
                "Depths, places, hiding places and reports use this permittivity. The search "
                "begins again with it."
            )
        )

    def _key(self, value: Optional[float]) -> QPushButton:
        return self.choice(lambda: self._choose(value))

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


class DoubtsSheet(ResultSheet):
    """Says what of the survey may not be believed, and what to do first."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self.add_text()
        self.progress.hide()
        self.retranslate()

    def show_now(self) -> None:
        """Show all of it."""
        found = texts.doubts(self.result)
        self.title.setText(self.tr("What is doubted"))
        self.text.setText("\n\n".join(map(with_remedy, found)))
        if not found:
            self.hide()


class HidingSheet(ResultSheet):
    """Asks where a mine of a size could hide, and says what the answer means."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self.targets = {one: self._key(one) for one in Targets}
        self.cancel = new_button(lambda: self.result.hiding.end())
        self.add_row(list(self.targets.values()))
        self.add_text(self.cancel)
        self.retranslate()

    def show_now(self) -> None:
        """Show the targets, and the answer for the last one."""
        job = self.result.hiding
        self.title.setText(self.tr("Where could a mine hide?"))
        self.cancel.setText(self.tr("CANCEL"))
        self.cancel.setVisible(job.running)
        for target, key in self.targets.items():
            size = f"{MM_PER_M * target.value.diameter_m:g} mm"
            chosen = target.value == self.result.target and job.state is not JobState.READY
            self.show_choice(key, f"{shown_text(texts.TARGETS[target])}\n{size}", chosen)
            key.setEnabled(not job.running)
        rest = self.tr("Choose a size. The search takes up to some minutes.")
        if job.running:
            rest = self.tr("Searching for {seconds} s.").format(seconds=int(job.running_s))
        elif job.result is not None:
            lines = [ONLY_THIS, *job.result.details]
            hatched = self.tr("Hatched on the image: where it could hide.")
            rest = "\n".join([hatched, *map(sentence_text, lines)])
        self.show_job(job, rest)

    def _key(self, target: Targets) -> QPushButton:
        return self.choice(lambda: self.result.choose_target(target))


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
