"""The values of other sensors as variables of a survey's Dataset."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from gpr20_analysis.dataset import AUX_PREFIX
from gpr20_common.message import Message
from gpr20_survey.trace.aux_value import AuxValue

# xarray reads numbers of these units as times.
TIME_UNITS = {
    **{"days": "d", "hours": "h", "minutes": "min", "seconds": "s"},
    **{"milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns"},
}


def aux_variables(
    values: Sequence[Tuple[AuxValue, ...]], cells: np.ndarray, size: int, notes: List[Message]
) -> Dict[str, Tuple[np.ndarray, Dict[str, Any]]]:
    """Return the values and the attributes of each variable `aux_<name>`.

    Args:
        values: Those of each sample.
        cells: The place of each sample in the grid.
        size: Places of the grid; those without a value are NaN.
        notes: A remark on a sensor whose unit changed is added here; the values of its second
            unit are in the variable `aux_<name>_2`, and so on.
    """
    found: Dict[str, Tuple[np.ndarray, Dict[str, Any]]] = {}
    names: Dict[Tuple[str, str], str] = {}
    for cell, own in zip(cells, values):
        for one in own:
            key = one.name, one.unit
            if key not in names:
                names[key] = _free_name(one.name, found)
                found[names[key]] = np.full(size, np.nan), _attributes(one)
            found[names[key]][0][cell] = one.value
    for name in sorted({name for name, _unit in names}):
        units = [unit for own, unit in names if own == name]
        if len(units) > 1:
            notes.append(
                Message(
                    "the sensor {sensor} was recorded with different units: {units}",
                    sensor=name,
                    units=", ".join(map(repr, units)),
                )
            )
    return found


def _free_name(name: str, taken: Dict[str, Any]) -> str:
    free, number = f"{AUX_PREFIX}{name}", 1
    while free in taken:
        number += 1
        free = f"{AUX_PREFIX}{name}_{number}"
    return free


def _attributes(one: AuxValue) -> Dict[str, Any]:
    attributes = {"long_name": f"sensor {one.name}"}
    if " since " in one.unit:
        attributes["long_name"] += f" [{one.unit}]"
    elif one.unit:
        attributes["units"] = TIME_UNITS.get(one.unit.lower(), one.unit)
    return attributes
