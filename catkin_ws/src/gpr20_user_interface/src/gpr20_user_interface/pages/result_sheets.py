"""What opens over the result: doubts, hiding places, the USB stick, and what all sheets share."""

from __future__ import annotations

from functools import partial
from typing import Callable, Tuple

from PyQt5.QtWidgets import QProgressBar, QPushButton, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.texts import HATCHED
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Job, JobState
from gpr20_operator.jobs.result import ALL_DATA, CANCELLING, REPORT, SurveyResult
from gpr20_operator.robot.condition import first_step
from gpr20_survey.results.answers import ExportPart, Volume
from gpr20_survey.results.candidates import NO_CLEARANCE
from gpr20_survey.results.hiding_map import MM_PER_M, ONLY_THIS, Targets
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.widgets.tile import SurveyBand
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    PulledText,
    column,
    new_button,
    new_label,
    row,
    say,
)

LONGEST_NAME = 12
MOST_STICKS = 3
BYTES_PER_GB = 1e9


def with_remedy(problem: Message) -> str:
    """Return a problem, and what to do first."""
    return "\n".join(
        sentence_text(one) for one in (problem, first_step(problem)) if one is not None
    )


class ResultSheet(Overlay):
    """A title, rows of keys, a text, a bar while something runs, and what the list is not.

    Args:
        window: The window that it covers.
        result: The result.
    """

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window)
        self.result = result
        self._drawn: object = None
        self.title, self.text, self.progress = new_label("title"), PulledText(), QProgressBar()
        self.progress.setRange(0, 0)  # it is not known how long it takes
        self.progress.hide()
        self.close_button = new_button(self.hide, Message("CLOSE"))
        self.no_clearance = new_label("alarm", wraps=True, text=NO_CLEARANCE)
        self.band = SurveyBand()
        self._page = column(self.band, self.title, margin=GAP_PX)
        self.setLayout(self._page)

    def refresh(self) -> None:
        """Show what has changed, while it is open."""
        revision = self.result.revision
        if self.isVisible() and revision != self._drawn:
            self._drawn = revision
            self.show_now()

    def show_now(self) -> None:
        """Show what is known now."""

    def open_now(self) -> None:
        """Open with what is known now."""
        self.band.show_band(texts.band(self.result))
        self.show_now()
        self.open()

    def add_row(self, *widgets: QWidget) -> None:
        """Add a row of keys."""
        self._page.addLayout(row(*((one, 1) for one in widgets)))

    def add_text(self) -> None:
        """Add the text, and the bar below it."""
        self._page.addWidget(self.text, 1)
        self._page.addWidget(self.progress)

    def add_end(self, *keys: QWidget) -> None:
        """Add the last keys, and what the list is not."""
        self.add_row(*keys, self.close_button)
        self._page.addWidget(self.no_clearance)
        self.show_now()

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


class DoubtsSheet(ResultSheet):
    """Says what of the survey may not be believed, and what to do first."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self.add_text()
        self.add_end()

    def show_now(self) -> None:
        """Show all of it."""
        found = texts.doubts(self.result)
        say(self.title, Message("What is doubted"))
        self.text.setText("\n\n".join(map(with_remedy, found)))
        if not found:
            self.hide()


class HidingSheet(ResultSheet):
    """Asks where a mine of a size could hide, and says what the answer means."""

    def __init__(self, window: QWidget, result: SurveyResult) -> None:
        super().__init__(window, result)
        self.targets = {one: self.choice(partial(result.choose_target, one)) for one in Targets}
        self.cancel = new_button(lambda: self.result.hiding.end(), Message("CANCEL"))
        self.add_row(*self.targets.values())
        self.add_text()
        self.add_end(self.cancel)

    def show_now(self) -> None:
        """Show the targets, and the answer for the last one."""
        job = self.result.hiding
        say(self.title, Message("Where could a mine hide?"))
        self.cancel.setVisible(job.running)
        for target, key in self.targets.items():
            size = f"{MM_PER_M * target.value.diameter_m:g} mm"
            chosen = target.value == self.result.target and job.state is not JobState.READY
            self.show_choice(key, f"{shown_text(texts.TARGETS[target])}\n{size}", chosen)
            key.setEnabled(not job.running)
        rest = self.tr("Choose a size. The search takes up to some minutes.")
        if job.running:
            rest = self.tr("Searching; this takes up to some minutes.")
        elif job.result is not None:
            lines = [ONLY_THIS, *job.result.details]
            rest = "\n".join(map(sentence_text, [HATCHED, *lines]))
        self.show_job(job, rest)


class StickSheet(ResultSheet):
    """The report on the stick that is touched, how far it is, and when it can be removed.

    Args:
        window: The window that it covers.
        result: The result.
        language: Returns the code of the window's language.
    """

    def __init__(self, window: QWidget, result: SurveyResult, language: Callable[[], str]) -> None:
        super().__init__(window, result)
        self._language = language
        self._parts: Tuple[ExportPart, ...] = REPORT
        self.report, self.all_data = self._part(REPORT), self._part(ALL_DATA)
        self.sticks = [self._stick(number) for number in range(MOST_STICKS)]
        stop = lambda: self.result.export.job.cancel(CANCELLING)  # noqa: E731
        self.cancel = new_button(stop, Message("CANCEL"))
        self.add_row(self.report, self.all_data)
        self.add_row(*self.sticks)
        self.add_text()
        self.add_end(self.cancel)

    def ask(self) -> None:
        """Open, and look for sticks."""
        self._parts = REPORT
        self.result.export.begin()
        self.open_now()

    def refresh(self) -> None:
        """Look for sticks while it is open."""
        if self.isVisible():
            self.result.export.look_for_sticks()
        super().refresh()

    def show_now(self) -> None:
        """Show what is written where."""
        export = self.result.export
        running = export.job.running
        self.cancel.setVisible(running)
        self.show_choice(self.report, self.tr("Report"), self._parts is REPORT)
        self.show_choice(self.all_data, self.tr("All data"), self._parts is ALL_DATA)
        for key in (self.report, self.all_data):
            key.setVisible(not running)
        for key, volume in zip(self.sticks, export.sticks.volumes):
            key.setText(f"{volume.name[:LONGEST_NAME]}\n{self._room(volume)}")
            key.setEnabled(volume.writable)
        for number, key in enumerate(self.sticks):
            key.setVisible(not running and number < len(export.sticks.volumes))
        title, text = self._sentences()
        record = self.result.record
        if record is not None and export.survey not in ("", record.survey_id):
            text = "\n".join(filter(None, (self.tr("This is the export of another survey."), text)))
        self.title.setText(title)
        self.show_job(export.job, text)

    def _sentences(self) -> Tuple[str, str]:
        """Return what to do with the stick, and what happens."""
        export, exported = self.result.export, self.result.export.job.result
        problem = export.job.problem or export.listing.problem
        if export.job.running:
            stage = export.job.stage
            waiting = self.tr("Waiting for the computer of the storage.")
            text = waiting if stage is None else sentence_text(stage)
            return self.tr("Do not remove the stick."), text
        if exported is not None:
            files = exported.files
            text = self.tr("Files: {count}, in its folder {folder}.")
            where = text.format(count=len(files), folder=files[0].split("/")[0])
            return self.tr("Done. Remove the stick."), where
        if problem is not None:
            return self.tr("Nothing was written."), with_remedy(problem)
        if not export.sticks.computer:
            return self.tr("Looking for USB sticks."), ""
        if not any(one.writable for one in export.sticks.volumes):
            text = self.tr("Plug a USB stick into the computer {computer}.")
            return text.format(computer=export.sticks.computer), ""
        return self.tr("Touch the stick that it is written to."), ""

    def _room(self, volume: Volume) -> str:
        if not volume.writable:
            return self.tr("write-protected")
        return shown_text(Message("{free:.1f} GB free", free=volume.free_bytes / BYTES_PER_GB))

    def _part(self, parts: Tuple[ExportPart, ...]) -> QPushButton:
        def act() -> None:
            self._parts = parts
            self.show_now()

        return self.choice(act)

    def _stick(self, number: int) -> QPushButton:
        def act() -> None:
            record, export = self.result.record, self.result.export
            if record is not None and number < len(export.sticks.volumes):
                volume = export.sticks.volumes[number]
                export.write(volume, record.survey_id, self._parts, self._language())

        key = new_button(act)
        key.setObjectName("choice")
        return key
