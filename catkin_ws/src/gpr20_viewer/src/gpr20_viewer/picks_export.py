"""Picks as CSV or JSON for other programs."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Dict

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_viewer.identity import SurveyIdentity
from gpr20_viewer.picks import NO_CLEARANCE_BY_PICKS, Pick, Picks

CSV, JSON = ".csv", ".json"
SHARED = ("survey_id", "survey_sha256", "simulated", "notice")
"""Columns that are the same in every row."""


def export_picks(picks: Picks, identity: SurveyIdentity, path: Path) -> None:
    """Write picks as .csv or .json; the words do not depend on the language.

    Raises:
        ExportError: The name has another ending, or the file cannot be written.
    """
    shared = dict(
        zip(
            SHARED,
            (
                identity.survey_id,
                identity.sha256,
                "SIMULATED" if identity.simulated else "",
                str(NO_CLEARANCE_BY_PICKS),
            ),
        )
    )
    if path.suffix == CSV:
        text = _csv(picks, shared)
    elif path.suffix == JSON:
        record = {**shared, "picks": [asdict(one) for one in picks]}
        text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    else:
        raise ExportError(wrong_ending(path, (CSV, JSON)))
    with atomic_output(path) as place:
        place.write_text(text, encoding="utf-8")


def _csv(picks: Picks, shared: Dict[str, str]) -> str:
    stream = io.StringIO()
    names = [field.name for field in fields(Pick)]
    writer = csv.DictWriter(stream, [*names, *SHARED], lineterminator="\n")
    writer.writeheader()
    for one in picks:
        writer.writerow({**asdict(one), **shared})
    return stream.getvalue()
