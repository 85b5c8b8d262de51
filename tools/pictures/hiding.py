"""The map of where a mine could hide in the sample survey."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from gpr20_analysis import hiding_figure, read_hiding, sample_survey
from gpr20_analysis.commands.main import main

RESOLUTION_DPI = 110


def make(folder: Path) -> None:
    """Make the map with the command, and draw it."""
    stored = folder / "hiding.json"
    command = ["hiding", str(sample_survey()), "--permittivity", "5", "--rounds", "24"]
    with contextlib.redirect_stdout(io.StringIO()):
        if main([*command, "-o", str(stored)]):
            raise SystemExit("gpr20 hiding has failed")
    path = folder / "hiding.png"
    hiding_figure(read_hiding(stored)).savefig(str(path), dpi=RESOLUTION_DPI)
    for one in (stored, stored.with_name(f"{stored.name}.sha256")):
        one.unlink()
    print(path)
