"""What can be exported of a survey, and what of the analysis writes it."""

from __future__ import annotations

import enum

from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_imaging.errors import ImagingError


class ExportKind(enum.Enum):
    """One file of an export."""

    REPORT_HTML = "report-html"
    CANDIDATES_CSV = "candidates-csv"
    CANDIDATES_GEOJSON = "candidates-geojson"
    SURVEY_ZIP = "survey-zip"

    @property
    def ending(self) -> str:
        """End of the file's name."""
        return {
            ExportKind.REPORT_HTML: "report.html",
            ExportKind.CANDIDATES_CSV: "candidates.csv",
            ExportKind.CANDIDATES_GEOJSON: "candidates.geojson",
            ExportKind.SURVEY_ZIP: "survey.zip",
        }[self]

    @property
    def analysis(self) -> str:
        """What the analysis writes: "report" or "candidates"; empty: it is not needed."""
        if self is ExportKind.SURVEY_ZIP:
            return ""
        return "report" if self is ExportKind.REPORT_HTML else "candidates"

    @property
    def message(self) -> Message:
        """What people call it."""
        return {
            ExportKind.REPORT_HTML: Message("report as HTML"),
            ExportKind.CANDIDATES_CSV: Message("candidates as CSV"),
            ExportKind.CANDIDATES_GEOJSON: Message("candidates as GeoJSON"),
            ExportKind.SURVEY_ZIP: Message("whole survey as ZIP"),
        }[self]

    @classmethod
    def of(cls, name: str) -> ExportKind:
        """Return the kind of a name.

        Raises:
            ImagingError: There is none.
        """
        for one in cls:
            if one.value == name:
                return one
        raise ImagingError(
            Message(
                "{name} cannot be exported; allowed: {kinds}",
                name=repr(name[:64]),
                kinds=", ".join(one.value for one in cls),
            ),
            fault=NOT_ALLOWED,
        )
