"""The file NAME.sha256 beside an exported file or folder NAME: checksums and facts.

It has the format of sha256sum, so `sha256sum -c NAME.sha256` checks the export too. Comment lines
at its beginning and end hold the facts of the survey, as JSON, and a checksum of the file itself.
It is beside a folder instead of in it, because the group's programs read every file of a folder as
a trace.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Dict, List, Optional

import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.provenance import Facts
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable
from gpr20_survey.files.file_sums import regular_files, sum_of_file

ENDING = ".sha256"
FACTS, OWN_SUM = "# gpr20 ", "# sha256 of the lines above "


def sums_path(export: Path) -> Path:
    """Return the path of the file beside an export."""
    return export.with_name(export.name + ENDING)


def write_sums(export: Path, survey: xr.Dataset, path: Path) -> None:
    """Write the file of checksums of a complete export.

    Args:
        export: File or folder.
        survey: What was exported.
        path: File to write.

    Raises:
        OSError: It cannot be written.
    """
    facts = json.dumps(Facts.of(survey).as_json(), ensure_ascii=True)
    lines = [FACTS + facts]
    lines += [f"{digest}  {name}" for name, digest in _sums(export).items()]
    text = "".join(f"{line}\n" for line in lines)
    own = hashlib.sha256(text.encode("utf-8")).hexdigest()
    path.write_text(f"{text}{OWN_SUM}{own}\n", encoding="utf-8")


def remove_sums(export: Path) -> None:
    """Remove the file of checksums of an export that is about to be replaced.

    Raises:
        OSError: It cannot be removed.
    """
    path = sums_path(export)
    if path.is_dir():
        shutil.rmtree(str(path))
    elif path.exists():
        path.unlink()


def checked_facts(export: Path) -> Optional[Facts]:
    """Return what the file beside an export says of it; None if there is no such file.

    Raises:
        UnreadableFileError: The file, or a file of the export, is not as it was written.
        OSError: One of them cannot be read.
    """
    path = sums_path(export)
    if not path.is_file():
        return None
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
    own = hashlib.sha256("".join(lines[:-1]).encode("utf-8")).hexdigest()
    if not lines or lines[-1] != f"{OWN_SUM}{own}\n" or not lines[0].startswith(FACTS):
        raise _damaged(path)
    listed = _listed(lines[1:-1])
    # The name of the export is left out: it may have been renamed.
    found = {_inside(name): digest for name, digest in _sums(export).items()}
    wrong = [one for one in {**listed, **found} if listed.get(one) != found.get(one)]
    if wrong:
        raise UnreadableFileError(
            Message(
                "{count} files of {export} differ from {sums}: {file} was changed, added or "
                "removed; export the survey again, or delete {sums} if that was intended",
                count=len(wrong),
                export=export.name,
                sums=path.name,
                file=min(wrong) or export.name,
            ),
            fault=faults.FILE_DAMAGED,
        )
    try:
        return Facts.from_json(json.loads(lines[0][len(FACTS) :]))
    except (KeyError, TypeError, ValueError) as error:
        raise _damaged(path) from error


def _damaged(path: Path) -> UnreadableFileError:
    return UnreadableFileError(
        Message(
            "{file} is damaged, so the files cannot be checked; export the survey again, or "
            "delete {file} to import them without a check",
            file=path.name,
        ),
        fault=faults.FILE_DAMAGED,
    )


def _listed(lines: List[str]) -> Dict[str, str]:
    pairs = (line.rstrip("\n").split("  ", 1) for line in lines)
    return {_inside(name): digest for digest, name in pairs}


def _inside(name: str) -> str:
    """Return the name of a file inside the exported folder; empty for an exported file."""
    return name.partition("/")[2]


def _sums(export: Path) -> Dict[str, str]:
    if not export.is_dir():
        return {storable(export.name): sum_of_file(export).sha256}
    return {
        storable(f"{export.name}/{name}"): sum_of_file(export / name).sha256
        for name in regular_files(export)
    }
