"""The export of a stored survey to a USB stick: what, where, and how far it is."""

from __future__ import annotations

from typing import Callable, Dict, List

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gpr20_operator.jobs.export import ExportPart, ExportState, SurveyExport
from gpr20_operator.jobs.search import PERMITTIVITY_RANGE, check_permittivity
from gpr20_operator.plan.spec import Keys
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.results.volume import Volume
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.edits import TouchEdit
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.labels import PulledText
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

MOST_STICKS = 3
LONGEST_NAME = 12
BYTES_PER_MB, BYTES_PER_GB = 1e6, 1e9


class ExportSheet(Overlay):
    """Shows a SurveyExport.

    Args:
        window: The window that it covers.
        export: The export.
        language: Returns the code of the window's language.
    """

    def __init__(self, window: QWidget, export: SurveyExport, language: Callable[[], str]) -> None:
        super().__init__(window)
        self.model = export
        self._language = language
        self._shown_revision = -1
        self._part_texts: Dict[ExportPart, str] = {}
        self.title = QLabel()
        self.title.setObjectName("title")
        self.simulated = QLabel()
        self.simulated.setObjectName("simulated")
        self.parts: Dict[ExportPart, QPushButton] = {
            part: self._toggle(part) for part in ExportPart
        }
        self.permittivity_label = QLabel()
        self.permittivity = TouchEdit("permittivity")
        self.number_pad = Pad(window)
        self.place = QLabel()
        self.place.setWordWrap(True)
        self.place.setTextFormat(Qt.TextFormat.PlainText)
        self.sticks: List[QPushButton] = [self._stick(number) for number in range(MOST_STICKS)]
        self.details = PulledText()
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)  # it is not known how long it takes
        self.export_button = new_button(self._on_export)
        self.cancel = new_button(self._on_cancel)
        self.close_button = new_button(self.hide)
        self.permittivity.tapped.connect(self._on_tap)
        self.permittivity.textChanged.connect(self._show)
        self._lay_out()
        self.retranslate()

    def show_survey(self, survey: SurveySummary) -> None:
        """Open for a survey."""
        self.model.choose(survey)
        self.open()
        self.refresh()

    def refresh(self) -> None:
        """Show the export if it has changed; look for sticks while the sheet is open."""
        if self.isVisible():
            self.model.look_for_sticks()
        if self.model.revision != self._shown_revision:
            self._show()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.simulated.setText(self.tr("SIMULATED"))
        self._part_texts = {
            ExportPart.REPORT_PDF: self.tr("Report\nPDF"),
            ExportPart.REPORT_HTML: self.tr("Report\nHTML"),
            ExportPart.CANDIDATES_CSV: self.tr("Candidates\nCSV"),
            ExportPart.CANDIDATES_GEOJSON: self.tr("Candidates\nGeoJSON"),
            ExportPart.SURVEY_ZIP: self.tr("All data\nZIP"),
        }
        self.permittivity_label.setText(self.tr("Permittivity"))
        self.export_button.setText(self.tr("EXPORT"))
        self.cancel.setText(self.tr("CANCEL"))
        self.close_button.setText(self.tr("CLOSE"))
        self._show()

    def _show(self) -> None:
        model = self.model
        self._shown_revision = model.revision
        survey, running = model.survey, model.state is ExportState.RUNNING
        self.title.setText(
            self.tr("Export of {survey}").format(
                survey="" if survey is None else survey.name or survey.local_time()
            )
        )
        self.simulated.setVisible(survey is not None and survey.simulated)
        for part, button in self.parts.items():
            button.setChecked(part in model.parts)
            button.setText(_marked(self._part_texts[part], part in model.parts))
            button.setEnabled(not running)
        wrong = check_permittivity(self.permittivity.text())
        self.permittivity.show_problem("" if wrong is None else shown_text(wrong))
        self._show_sticks(running)
        self.export_button.setEnabled(model.can_start and wrong is None)
        self.cancel.setEnabled(running)
        self.progress.setVisible(running)
        self.details.setText(self._sentence())

    def _show_sticks(self, running: bool) -> None:
        volumes = self.model.volumes[:MOST_STICKS]
        for button in self.sticks[len(volumes) :]:
            button.hide()
        for button, volume in zip(self.sticks, volumes):
            chosen = volume.path == self.model.volume
            text = f"{volume.name[:LONGEST_NAME]}\n{self._room(volume)}"
            button.setText(_marked(text, chosen))
            button.setChecked(chosen)
            button.setEnabled(volume.writable and not running)
            button.show()
        if not self.model.computer:
            text = self.tr("Looking for USB sticks.")
        elif volumes:
            text = self.tr("USB stick in the computer {computer}:")
        else:
            text = self.tr("Plug a USB stick into the computer {computer}.")
        self.place.setText(text.format(computer=self.model.computer))

    def _room(self, volume: Volume) -> str:
        if not volume.writable:
            return self.tr("write-protected")
        if volume.free_bytes < BYTES_PER_GB:
            return self.tr("{free:.0f} MB free").format(free=volume.free_bytes / BYTES_PER_MB)
        return self.tr("{free:.1f} GB free").format(free=volume.free_bytes / BYTES_PER_GB)

    def _sentence(self) -> str:
        model = self.model
        if model.state is ExportState.RUNNING:
            waiting = self.tr("Waiting for the computer of the storage.")
            stage = waiting if model.stage is None else shown_text(model.stage)
            return self.tr("Do not remove the stick: {stage}").format(stage=stage)
        if model.problem is not None:
            return shown_text(model.problem)
        if model.state is ExportState.DONE:
            return self.tr(
                "{count} files are on the stick, in the folder {folder}. It can be removed."
            ).format(count=len(model.files), folder=model.files[0].split("/")[0])
        return self.tr(
            "Each file gets a checksum file. A report is no clearance: it says so on every page."
        )

    def _on_export(self) -> None:
        self.model.start(self.permittivity.text(), self._language())
        self._show()

    def _on_cancel(self) -> None:
        self.model.cancel()
        self._show()

    def _on_tap(self) -> None:
        def judge(text: str) -> str:
            wrong = check_permittivity(text)
            return "" if wrong is None else shown_text(wrong)

        self.number_pad.ask(
            self.permittivity.setText,
            self.permittivity_label.text(),
            shown_text(PERMITTIVITY_RANGE),
            self.permittivity.text(),
            judge,
            Keys.NUMBER,
            strict=False,
        )

    def _toggle(self, part: ExportPart) -> QPushButton:
        def act() -> None:
            self.model.toggle(part)
            self._show()

        button = new_button(act)
        button.setCheckable(True)
        button.setObjectName("choice")
        return button

    def _stick(self, number: int) -> QPushButton:
        def act() -> None:
            self.model.choose_volume(self.model.volumes[number].path)
            self._show()

        button = new_button(act)
        button.setCheckable(True)
        button.setObjectName("choice")
        return button

    def _lay_out(self) -> None:
        top = QHBoxLayout()
        top.addWidget(self.title, 1)
        top.addWidget(self.simulated)
        chosen = QGridLayout()
        chosen.setSpacing(GAP_PX)
        for number, button in enumerate(self.parts.values()):
            chosen.addWidget(button, number // 3, number % 3)
        entry = QHBoxLayout()
        entry.addWidget(self.permittivity_label)
        entry.addWidget(self.permittivity, 1)
        chosen.addLayout(entry, 1, 2)
        for column in range(3):
            chosen.setColumnStretch(column, 1)
        sticks = QHBoxLayout()
        sticks.setSpacing(GAP_PX)
        sticks.addWidget(self.place, 1)
        for button in self.sticks:
            sticks.addWidget(button)
        page = QVBoxLayout(self)
        page.setContentsMargins(GAP_PX, 4, GAP_PX, 4)
        page.setSpacing(GAP_PX)
        page.addLayout(top)
        page.addLayout(chosen)
        page.addLayout(sticks)
        page.addWidget(self.details, 1)
        page.addWidget(self.progress)
        buttons = QHBoxLayout()
        buttons.setSpacing(GAP_PX)
        for button in (self.export_button, self.cancel, self.close_button):
            buttons.addWidget(button, 1)
        page.addLayout(buttons)


def _marked(text: str, chosen: bool) -> str:
    # Not by the colour alone.
    return f"\N{CHECK MARK} {text}" if chosen else text
