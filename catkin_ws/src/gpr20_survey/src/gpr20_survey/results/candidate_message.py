"""A list of candidates as the fields of gpr20_msgs/CandidateList.

A message has no None: what is not known is NaN, and a list of positions is empty.
"""

from __future__ import annotations

import math
from typing import Any, Dict, List, Tuple

from gpr20_survey.results.candidate_json import candidate_record, list_record
from gpr20_survey.results.candidates import CandidateList

OF_LIST = (
    *("format", "simulated_warning", "listed", "coordinates", "permittivity_source"),
    "notes_json",
)
OF_EACH = ("doubtful", "longitude_deg", "latitude_deg")
"""What the JSON says too; all but the source follows from the fields of the messages."""
UNKNOWN = ("false_alarms_per_m2", "polarization_ratio_db")
UNKNOWN_OF_LIST = ("false_alarms_per_m2", "false_alarms_lowest", "false_alarms_highest")


def list_fields(found: CandidateList) -> Tuple[Dict[str, Any], List[Dict[str, Any]]]:
    """Return the fields of a list without its candidates, and those of each candidate.

    The entries of `position` are the fields of gpr20_msgs/AreaPosition.
    """
    fields = {name: value for name, value in list_record(found).items() if name not in OF_LIST}
    for name in UNKNOWN_OF_LIST:
        fields[name] = math.nan if fields[name] is None else fields[name]
    fields["position"] = [] if fields["position"] is None else [fields["position"]]
    each = []
    for one in found.candidates:
        record = candidate_record(one, found)
        values = {name: value for name, value in record.items() if name not in OF_EACH}
        values["rotations_deg"] = list(one.rotations_deg)
        for name in UNKNOWN:
            values[name] = math.nan if values[name] is None else values[name]
        each.append(values)
    return fields, each
