"""What a survey's folder holds, read with tools that are not those that wrote it."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from typing import Any, Dict, List, Optional

from stock_readers import bag_traces, mcap_traces, torn_mcap_traces
from storage_kit import with_bag

from fault_suite.facts import Found
from gpr20_survey.errors import ProcessingError


def survey_in(data: Path) -> Optional[Path]:
    """Return the folder of the survey in a data folder, if there is one."""
    return next((one for one in sorted(data.iterdir()) if (one / "traces").is_dir()), None)


def traces_of_torn(folder: Path) -> Found:
    """Return the traces of a survey that was cut off; it has no bag."""
    mcap = folder / "survey.mcap"
    messages = list(torn_mcap_traces(mcap)) if mcap.is_file() else []
    return Found({"JSON": _json_traces(folder), "MCAP": messages})


def everything_of(folder: Path) -> Found:
    """Return all that is in the folder of a survey that has ended; its bag is made."""
    forms = {"JSON": _json_traces(folder), "MCAP": list(mcap_traces(folder / "survey.mcap"))}
    with contextlib.suppress(ProcessingError):  # of a survey that is named as damaged
        with_bag(folder)
        forms["bag"] = list(bag_traces(folder / "survey.bag"))
    description = json.loads((folder / "survey.json").read_text("utf-8"))
    return Found(
        forms,
        description.get("markers", []),
        description.get("annotation"),
        description.get("report"),
    )


def log_of(folder: Path) -> Optional[Found]:
    """Return what the log of a survey says by itself; None: a survey of an earlier version.

    Raises:
        ValueError: A line is not as it was written, or not behind the one before it.
    """
    path = folder / "log.jsonl"
    if not path.exists():
        return None
    found, last = Found(), (-1, "")
    markers: Dict[str, Dict[str, Any]] = {}
    # What is behind the last line feed was being added, and is not acknowledged; of a line that
    # was torn, its last sector may be there alone.
    *lines, _rest = path.read_bytes().split(b"\n")
    if lines and not _is_json(lines[-1]):
        lines.pop()
    for line in lines:
        record = json.loads(line)
        number, kind, values = record["number"], record["kind"], record["values"]
        hashed = [number, record["time"], kind, values, record["previous"]]
        text = json.dumps(hashed, separators=(",", ":"))
        own_sum = hashlib.sha256(text.encode("ascii")).hexdigest()
        # A record that is missing is a fact that is missed; one behind it stands for itself. The
        # values of a report that was replaced may have been left out.
        follows = number > last[0] + 1 or (number - 1, record["previous"]) == last
        if not follows or (values is not None and record["sha256"] != own_sum):
            raise ValueError(f"log.jsonl: not as it was written: {line!r}")
        last = number, record["sha256"]
        if kind in ("marker", "marker_removed"):
            markers.setdefault(values["marker_id"], {}).update(values)
        elif kind in ("annotation", "report") and values is not None:
            setattr(found, kind, values)
    found.markers = list(markers.values())
    return found


def _is_json(line: bytes) -> bool:
    try:
        return isinstance(json.loads(line), dict)
    except ValueError:
        return False


def _json_traces(folder: Path) -> List[Any]:
    return list(filter(None, map(_json_trace, sorted(folder.glob("traces/[!.]*.json")))))


def _json_trace(path: Path) -> Optional[Dict[str, Any]]:
    try:
        values = json.loads(path.read_text("utf-8"))
    except ValueError:
        return None  # is no trace; one that was acknowledged is missed
    return values if isinstance(values, dict) else {}
