"""The fields of traces as variables of a survey's Dataset."""

from __future__ import annotations

import math
from typing import Any, Collection, Dict, List, Sequence, Tuple

import numpy as np

from gpr20_analysis.dataset import AXIS, HEIGHT, SAMPLE_DIMS
from gpr20_analysis.read.survey_attributes import OF_ANALYZER
from gpr20_analysis.read.trace_table import COLUMNS, Sample
from gpr20_survey.trace.trace import TRACE_FIELDS
from gpr20_survey.trace.trace_form import TraceField
from gpr20_survey.trace.utc_time import NS_PER_US

# They are coordinates, attributes, or the variables `aux_<name>`.
ELSEWHERE = ("format", "survey_id", "x_coord_mm", "y_coord_mm", "z_coord_deg", "aux")
NAMES = {"antennae_height_m": HEIGHT, "quality": "remarks"}
NEVER = np.datetime64("NaT", "ns")


def trace_variables(
    samples: Sequence[Sample],
    cells: np.ndarray,
    shape: Tuple[int, ...],
    unknown_times: Collection[str],
) -> Dict[str, Tuple[Tuple[str, ...], np.ndarray]]:
    """Return dimensions and values of each variable.

    What no sample knows is left out, but for the height, and so is a setting of the analyzer that
    all samples share: it is an attribute.

    Args:
        samples: The samples.
        cells: The place of each in the flat grid.
        shape: Shape of the grid.
        unknown_times: Names of the times that the traces have because they must have some.
    """
    found = {}
    for one in TRACE_FIELDS:
        if one.attribute not in COLUMNS or one.name in ELSEWHERE:
            continue
        values = [sample[one.attribute] for sample in samples]
        name = NAMES.get(one.name, one.name)
        is_shared = name in OF_ANALYZER and len(set(values)) == 1
        if is_shared or (name != HEIGHT and all(map(one.is_unknown, values))):
            continue
        own, empty = _array(one, len(values) * [0] if name in unknown_times else values)
        placed = np.full((math.prod(shape), *own.shape[1:]), empty, own.dtype)
        placed[cells] = own
        dims = (*SAMPLE_DIMS, AXIS)[: len(shape) + own.ndim - 1]
        found[name] = dims, placed.reshape(*shape, *own.shape[1:])
    return found


def _array(field: TraceField, values: List[Any]) -> Tuple[np.ndarray, Any]:
    """Return an array, and what it holds where there is no sample or the value is not known."""
    kind = field.form.ros.partition("[")[0]
    if kind == "time":
        times_ns = np.array(values, np.int64) * NS_PER_US
        return np.where(times_ns == 0, NEVER, times_ns.astype("datetime64[ns]")), NEVER
    if kind == "string":
        texts = [one if isinstance(one, str) else "; ".join(one) for one in values]
        return np.array(texts, np.str_), ""
    if kind == "float64":
        return np.array([math.nan if field.is_unknown(one) else one for one in values]), math.nan
    return np.array(values, np.int64), -1 if field.unknown is None else field.unknown
