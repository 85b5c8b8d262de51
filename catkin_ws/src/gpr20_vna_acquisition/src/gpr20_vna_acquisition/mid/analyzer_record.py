"""What the last check of an analyzer found: a file in the folder of the configuration."""

from __future__ import annotations

import enum
import hashlib
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Sequence

from gpr20_common import __version__
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.checks import is_extension
from gpr20_survey.files.durable_files import replace_file
from gpr20_survey.trace import utc_time
from gpr20_vna_acquisition.mid.analyzers import load_analyzer
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

FILE = "checked_analyzer.json"
FORMAT = "gpr20-analyzer-check/1"


class Status(enum.Enum):
    """How a check ended."""

    PASSED = "passed"
    FAILED = "failed"
    MEASURED = "measured"  # what the instrument does, neither good nor bad
    NOT_TESTED = "not tested"


@dataclass(frozen=True)
class Result:
    """The name of a check, for programs, how it ended, and what was found."""

    check: str
    status: Status
    text: Message


def passed(found: Sequence[Result]) -> bool:
    """Return whether no check failed."""
    return bool(found) and all(one.status is not Status.FAILED for one in found)


def has_passed(folder: Path, parameters: VnaParameters) -> bool:
    """Return whether the class that the parameters name has passed, as its source is now.

    Raises:
        InvalidValueError: It cannot be loaded.
    """
    try:
        stored = json.loads((folder / FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False  # what is not there, or damaged, shows nothing
    wanted = {"format": FORMAT, "passed": True, **_subject(parameters)}
    return isinstance(stored, dict) and {key: stored.get(key) for key in wanted} == wanted


def store(folder: Path, parameters: VnaParameters, found: Sequence[Result]) -> Path:
    """Store what was found in place of what was found before.

    Raises:
        OSError: The file cannot be written.
    """
    record: Dict[str, Any] = {
        "format": FORMAT,
        **_subject(parameters),
        "passed": passed(found),
        "checked": utc_time.iso_text(time_of_day_us()),
        "software": __version__,
        "results": [(one.check, one.status.value, str(one.text)) for one in found],
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / FILE
    replace_file(path, json.dumps(record, indent=2, sort_keys=True).encode("utf-8"))
    return path


def _subject(parameters: VnaParameters) -> Dict[str, str]:
    """Return what was checked: the MS2026C, or a class as its source is."""
    if not is_extension(parameters.analyzer):
        return {"analyzer": parameters.analyzer}
    return {
        "analyzer": parameters.analyzer,
        "options": json.dumps(parameters.analyzer_options, sort_keys=True, default=str),
        "source_sha256": _source_sha256(load_analyzer(parameters)),
    }


def _source_sha256(found: type) -> str:
    """Return the checksum of the class's module, or of all modules of its package."""
    package = sys.modules[found.__module__.partition(".")[0]]
    folders = [Path(one) for one in getattr(package, "__path__", ())]
    files = sorted(file for folder in folders for file in folder.rglob("*.py"))
    if not files:
        files = [Path(str(getattr(package, "__file__", None)))]
    checksum = hashlib.sha256()
    for file in filter(Path.is_file, files):
        checksum.update(file.name.encode("utf-8") + b"\0" + file.read_bytes() + b"\0")
    return checksum.hexdigest()
