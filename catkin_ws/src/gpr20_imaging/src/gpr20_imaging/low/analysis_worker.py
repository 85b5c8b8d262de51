"""What the node asks of the analysis; only its worker process loads the libraries for this."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Optional

import gpr20_analysis
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap, target_of

message_of = gpr20_analysis.message_of


class Analysis:
    """Keeps the traces of the survey that it has imaged last."""

    def __init__(self) -> None:
        self._survey: Optional[Any] = None

    def focus(self, folder: Path, permittivity: Optional[float]) -> FocusedImage:
        """Return the focused image of a survey, running or past."""
        if self._survey is None or self._survey.folder != folder:
            self._survey = gpr20_analysis.GrowingSurvey(folder)
        image: FocusedImage = gpr20_analysis.focus(self._survey.load(), permittivity)
        return image

    def map_hidden(self, folder: Path, permittivity: Optional[float], target: str) -> HidingMap:
        """Return where a target could hide in a survey."""
        survey = self._load(folder)
        detector = gpr20_analysis.Detector(gpr20_analysis.field_options(permittivity, survey))
        found: HidingMap = gpr20_analysis.map_hidden(survey, detector, target_of(target))
        return found

    def write_candidates(
        self, folder: Path, output: Path, permittivity: Optional[float], _language: str
    ) -> None:
        """Write the candidates of a survey."""
        survey = self._load(folder)
        options = gpr20_analysis.field_options(permittivity, survey)
        gpr20_analysis.write_candidates(gpr20_analysis.answer(survey, options).found, output)

    def write_report(
        self, folder: Path, output: Path, permittivity: Optional[float], language: str
    ) -> None:
        """Write the report on a survey."""
        survey = self._load(folder)
        options = gpr20_analysis.field_options(permittivity, survey)
        gpr20_analysis.write_report(survey, folder, output, options, language=language)

    def _load(self, folder: Path) -> Any:
        self._survey = None  # its memory is needed now
        return gpr20_analysis.load_survey(folder)
