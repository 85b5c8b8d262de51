"""A list of candidates as the fields of gpr20_msgs/CandidateList.

A message has no None: what is not known is NaN, and a list of positions is empty.
"""

from __future__ import annotations

import math
from typing import Any, Dict, List, Sequence, Tuple

from gpr20_survey.results.candidate_json import candidate_record, list_record
from gpr20_survey.results.candidates import CandidateList

OF_LIST = (
    *("format", "simulated_warning", "listed", "coordinates", "permittivity_source"),
    "notes_json",
)
OF_EACH = ("doubtful", "longitude_deg", "latitude_deg")
"""What the JSON says too; all but the source follows from the fields of the messages."""


def list_fields(found: CandidateList) -> Tuple[Dict[str, Any], List[Dict[str, Any]]]:
    """Return the fields of a list without its candidates, and those of each candidate.

    The entries of `position` are the fields of gpr20_msgs/AreaPosition.
    """
    record = list_record(found)
    fields = {**_sent(record, OF_LIST), "position": [one for one in [record["position"]] if one]}
    return fields, [_sent(candidate_record(one, found), OF_EACH) for one in found.candidates]


def _sent(record: Dict[str, Any], left_out: Sequence[str]) -> Dict[str, Any]:
    def number(value: Any) -> Any:
        return math.nan if value is None else value

    return {
        name: [number(one) for one in value] if isinstance(value, list) else number(value)
        for name, value in record.items()
        if name not in left_out
    }
