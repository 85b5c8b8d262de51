"""The child process that calls the analysis; only it loads the libraries that this needs."""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Optional

import gpr20_analysis
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hidden_target import target_of
from gpr20_survey.results.hiding_map import HidingMap


class Analysis:
    """What the node can ask for; keeps the traces that it has imaged last, and the last answers."""

    def __init__(self) -> None:
        self._survey: Optional[Any] = None
        self._kept = gpr20_analysis.KeptAnswers()

    def focus(self, folder: Path, permittivity: Optional[float]) -> FocusedImage:
        """Return the focused image of a survey, running or past."""
        if self._survey is None or self._survey.folder != folder:
            self._survey = gpr20_analysis.GrowingSurvey(folder)
        image: FocusedImage = self._kept.focus(self._survey.load(), permittivity)
        return image

    def map_hidden(self, folder: Path, permittivity: Optional[float], target: str) -> HidingMap:
        """Return where a target could hide in a survey."""
        found: HidingMap = gpr20_analysis.map_hidden_in_field(
            self._load(folder), permittivity, target_of(target)
        )
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


def serve(connection: Connection, analysis: Any) -> None:
    """Answer requests, each with the result and the reason why there is none, until the end."""
    while True:
        try:
            name, arguments = connection.recv()
        except EOFError:
            return
        try:
            answer = (getattr(analysis, name)(*arguments), None)
        except Exception as error:  # the node reports it, and the process stays
            traceback.print_exc()
            answer = (None, gpr20_analysis.message_of(error, f"imaging: {name}"))
        connection.send(answer)


def main() -> None:
    """Answer the requests of the connection whose file is the argument."""
    # What ends the process cleans up like Ctrl-C.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with Connection(int(sys.argv[1])) as connection:
        serve(connection, Analysis())


if __name__ == "__main__":
    main()
