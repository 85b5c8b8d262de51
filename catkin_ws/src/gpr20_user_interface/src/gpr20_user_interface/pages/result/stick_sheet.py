"""The sheet that writes the report on a stick."""

from __future__ import annotations

from typing import Callable, Tuple

from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.message import Message
from gpr20_operator.jobs.job import JobState
from gpr20_operator.jobs.result import SurveyResult
from gpr20_survey.results.volume import ExportPart, Volume
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.pages.result.sheets import LONGEST_NAME, ResultSheet, with_remedy
from gpr20_user_interface.widgets.widgets import new_button

MOST_STICKS = 3
BYTES_PER_MB, BYTES_PER_GB = 1e6, 1e9


class StickSheet(ResultSheet):
    """The report on a stick: where, how far it is, and when the stick can be removed.

    Args:
        window: The window that it covers.
        result: The result.
        language: Returns the code of the window's language.
    """

    def __init__(self, window: QWidget, result: SurveyResult, language: Callable[[], str]) -> None:
        super().__init__(window, result)
        self._language = language
        self.parts = {one: self._part(one) for one in ExportPart}
        self.sticks = [self._stick(number) for number in range(MOST_STICKS)]
        self.other = new_button(lambda: self.result.export.choose_parts())
        self.again = new_button(self.ask)
        self.cancel = new_button(lambda: self.result.export.cancel())
        self.add_row(list(self.parts.values()))
        self.add_row(self.sticks)
        self.add_text(self.again, self.other, self.cancel)
        self.retranslate()

    def ask(self) -> None:
        """Open, and write the report if there is one stick."""
        self.result.begin_export(self._language())
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
        self.other.setText(self.tr("Other files"))
        self.other.setVisible(not running and not export.choosing)
        self.again.setText(self.tr("TRY AGAIN"))
        self.again.setVisible(export.job.state is JobState.FAILED)
        self.cancel.setText(self.tr("CANCEL"))
        self.cancel.setVisible(running)
        names = {
            ExportPart.REPORT_HTML: self.tr("Report\nHTML"),
            ExportPart.CANDIDATES_CSV: self.tr("Places\nCSV"),
            ExportPart.CANDIDATES_GEOJSON: self.tr("Places\nGeoJSON"),
            ExportPart.SURVEY_ZIP: self.tr("All data\nZIP"),
        }
        for part, key in self.parts.items():
            self.show_choice(key, names[part], part in export.parts)
            key.setVisible(export.choosing)
        several = export.job.state is JobState.READY or export.choosing
        for key, volume in zip(self.sticks, export.offered):
            key.setText(f"{volume.name[:LONGEST_NAME]}\n{self._room(volume)}")
            key.setEnabled(volume.writable and bool(export.parts))
        for number, key in enumerate(self.sticks):
            key.setVisible(several and number < len(export.sticks.volumes))
        title, text = self._sentences()
        record = self.result.record
        if record is not None and export.survey not in ("", record.survey_id):
            text = "\n".join(filter(None, (self.tr("This is the export of another survey."), text)))
        self.title.setText(title)
        self.show_job(export.job, text)

    def _sentences(self) -> Tuple[str, str]:
        """Return what to do with the stick, and what happens."""
        export = self.result.export
        computer, listing = export.sticks.computer, export.listing
        if export.job.running:
            stage = export.job.stage
            waiting = self.tr("Waiting for the computer of the storage.")
            text = waiting if stage is None else sentence_text(stage)
            return self.tr("Do not remove the stick."), text
        exported = export.job.result
        if exported is not None:
            files = exported.files
            text = self.tr("Files: {count}, in its folder {folder}.")
            where = text.format(count=len(files), folder=files[0].split("/")[0])
            return self.tr("Done. Remove the stick."), where
        if listing.problem is not None or export.job.problem is not None:
            problem = listing.problem or export.job.problem
            return self.tr("Nothing was written."), "" if problem is None else with_remedy(problem)
        if not computer:
            return self.tr("Looking for USB sticks."), ""
        if not export.writable:
            text = self.tr("Plug a USB stick into the computer {computer}.")
            return text.format(computer=computer), ""
        return self.tr("Touch the stick that it is written to."), ""

    def _room(self, volume: Volume) -> str:
        if not volume.writable:
            return self.tr("write-protected")
        if volume.free_bytes < BYTES_PER_GB:
            return shown_text(Message("{free:.0f} MB free", free=volume.free_bytes / BYTES_PER_MB))
        return shown_text(Message("{free:.1f} GB free", free=volume.free_bytes / BYTES_PER_GB))

    def _part(self, part: ExportPart) -> QPushButton:
        return self.choice(lambda: self.result.export.toggle(part))

    def _stick(self, number: int) -> QPushButton:
        def act() -> None:
            export = self.result.export
            if number < len(export.offered):
                export.write(export.offered[number].path)

        key = new_button(act)
        key.setObjectName("choice")
        return key
