"""What a survey's folder holds, read with tools that are not those that wrote it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List, Optional

from stock_readers import bag_traces, mcap_traces, torn_mcap_traces

from fault_suite.facts import Found


def survey_in(data: Path) -> Optional[Path]:
    """Return the folder of the survey in a data folder, if there is one."""
    return next((one for one in sorted(data.iterdir()) if (one / "traces").is_dir()), None)


def traces_of_torn(folder: Path) -> Found:
    """Return the traces of a survey that was cut off; its bag has no index yet."""
    mcap = folder / "survey.mcap"
    messages = list(torn_mcap_traces(mcap)) if mcap.is_file() else []
    return Found({"JSON": _json_traces(folder), "MCAP": messages})


def everything_of(folder: Path) -> Found:
    """Return all that is in the folder of a survey that has ended."""
    description = json.loads((folder / "survey.json").read_text("utf-8"))
    return Found(
        {
            "JSON": _json_traces(folder),
            "MCAP": list(mcap_traces(folder / "survey.mcap")),
            "bag": list(bag_traces(folder / "survey.bag")),
        },
        description.get("markers", []),
        description.get("annotation"),
        description.get("report"),
    )


def _json_traces(folder: Path) -> List[Any]:
    return list(filter(None, map(_json_trace, sorted(folder.glob("traces/[!.]*.json")))))


def _json_trace(path: Path) -> Optional[Dict[str, Any]]:
    try:
        values = json.loads(path.read_text("utf-8"))
    except ValueError:
        return None  # is no trace; one that was acknowledged is missed
    return values if isinstance(values, dict) else {}
