"""gpr20 focus: focused images for a program that asks again and again, such as the robot's node."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_analysis.candidates.focused import focus
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.commands.failure import message_of
from gpr20_analysis.read.growing_survey import GrowingSurvey
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.sent_message import message_fields
from gpr20_survey.results.focused_image import FocusedImage, focus_fields


def add_arguments(_parser: argparse.ArgumentParser) -> None:
    """Declare the arguments: there are none."""


def run(_chosen: argparse.Namespace, _catalogue: Catalogue) -> int:
    """Answer each line of the standard input until it ends; return the exit status."""
    service = FocusService()
    for line in sys.stdin:
        print(json.dumps(service.answer(line), allow_nan=False), flush=True)
    return DONE


class FocusService:
    """Answers requests; keeps the traces of the survey that was asked for last."""

    def __init__(self) -> None:
        self._survey: Optional[GrowingSurvey] = None

    def answer(self, line: str) -> Dict[str, Any]:
        """Return the answer to a request.

        Args:
            line: JSON: `survey`, its folder; `permittivity`, null to estimate it; `levels`, the
                file to which the levels are written (depth, y, x) as float32, little endian.

        Returns:
            The fields of the image, or `error`, why there is none, as `message_fields` gives it.
        """
        try:
            request = json.loads(line)
            focused = self._focus(Path(request["survey"]), request["permittivity"])
            fields = focus_fields(focused)
            Path(request["levels"]).write_bytes(fields.pop("levels_db"))
        except (Gpr20Error, MemoryError, OSError) as error:
            return {"error": message_fields(message_of(error, "gpr20 focus"))}
        return fields

    def _focus(self, folder: Path, permittivity: Optional[float]) -> FocusedImage:
        if self._survey is None or self._survey.folder != folder:
            self._survey = GrowingSurvey(folder)
        return focus(self._survey.load(), permittivity)


COMMAND = Command(
    "Answer requests for focused images: one line of JSON on the standard input each, one line of "
    "JSON on the standard output as answer. Only new traces of a survey are read.",
    add_arguments,
    run,
)
