"""The worker process of the node: answers its requests one after the other, by the analysis.

Only it loads the libraries for this.
"""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, List, Optional, Tuple

import gpr20_analysis
from gpr20_common.message import Message
from gpr20_imaging.low.stick_files import UsbVolumes
from gpr20_imaging.mid.exporting import Exporter
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap, target_of

message_of = gpr20_analysis.message_of
# Memory is given back if nobody looks at images for so long [s].
IDLE_S = 60.0


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
        survey, options = self._load(folder, permittivity)
        detector = gpr20_analysis.Detector(options)
        found: HidingMap = gpr20_analysis.map_hidden(survey, detector, target_of(target))
        return found

    def write_candidates(
        self, folder: Path, output: Path, permittivity: Optional[float], _language: str
    ) -> None:
        """Write the candidates of a survey."""
        survey, options = self._load(folder, permittivity)
        gpr20_analysis.write_candidates(gpr20_analysis.answer(survey, options).found, output)

    def write_report(
        self, folder: Path, output: Path, permittivity: Optional[float], language: str
    ) -> None:
        """Write the report on a survey."""
        survey, options = self._load(folder, permittivity)
        gpr20_analysis.write_report(survey, folder, output, options, language=language)

    def _load(self, folder: Path, permittivity: Optional[float]) -> Tuple[Any, Any]:
        self._survey = None  # its memory is needed now
        survey = gpr20_analysis.load_survey(folder)
        return survey, gpr20_analysis.field_options(permittivity, survey)


def serve(connection: Connection, analysis: Any, volumes: UsbVolumes) -> None:
    """Answer each request with stages, then result and the reason why there is none; or end.

    Args:
        connection: To the node.
        analysis: As `Analysis`.
        volumes: The sticks.
    """

    def report(stage: Message) -> None:
        connection.send((stage, None, None))

    exporter = Exporter(analysis, volumes, report)
    work = {
        "focus": analysis.focus,
        "map_hidden": analysis.map_hidden,
        "export": exporter.export,
        "make": exporter.make,
    }
    while connection.poll(IDLE_S):
        try:
            name, arguments = connection.recv()
        except EOFError:
            return
        try:
            answer = (None, work[name](*arguments), None)
        except Exception as error:  # the node reports it, and the process stays
            traceback.print_exc()
            answer = (None, None, message_of(error, f"imaging: {name}"))
        connection.send(answer)


def main(arguments: List[str]) -> None:
    """Answer the requests of the connection whose file is the argument."""
    # What ends the process cleans up like Ctrl-C.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with Connection(int(arguments[0])) as connection:
        serve(connection, Analysis(), UsbVolumes())


if __name__ == "__main__":
    main(sys.argv[1:])
