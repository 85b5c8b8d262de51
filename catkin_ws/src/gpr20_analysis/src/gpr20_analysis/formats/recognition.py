"""Recognizes files that are no survey; of other formats it names the command that imports them."""

from __future__ import annotations

import shlex
from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.format import IMPORTS
from gpr20_common.message import Message

OUTPUT = "survey.nc"


def refuse_device(path: Path) -> None:
    """Refuse pipes, devices and the like, which some readers would wait for.

    Raises:
        AnalysisError: There is something, but neither a file nor a folder.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise AnalysisError(
            Message("{path} is neither a file nor a folder, so it is not a survey", path=path),
            fault=faults.INPUT,
        )


def refuse_importable(path: Path) -> None:
    """Refuse files of the formats of installed packages with the command that imports them.

    Raises:
        AnalysisError: It is such a file or folder.
    """
    for form in IMPORTS.added():
        whole = IMPORTS.find(form).whole(path)
        if whole is None:
            continue
        command = f"gpr20 import {shlex.quote(str(whole))} {OUTPUT} --format {form}"
        raise AnalysisError(
            Message(
                "{path} has the format {format}; import it first: {command}",
                path=path,
                format=form,
                command=command,
            ),
            fault=faults.INPUT,
        )
