"""Maps of where a target could hide, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from gpr20_survey.results.hiding_map import HidingMap, Targets


def a_map(found: Any, tried: Any, needed: float = 0.8, **changes: Any) -> HidingMap:
    """Return a map of places 100 mm apart and depths 20 mm apart.

    Args:
        found: How many targets were found (depth, y, x).
        tried: How many were tried.
        needed: Share that must be found.
        **changes: Other values of the map.
    """
    found, tried = np.asarray(found), np.asarray(tried)
    layers, rows, columns = found.shape
    values = {
        "survey_id": "a",
        "simulated": False,
        "target": Targets.PMN.value,
        "x_m": 0.1 * np.arange(columns),
        "y_m": 0.1 * np.arange(rows),
        "depth_m": 0.02 * np.arange(1, layers + 1),
        "tried": tried,
        "found": found,
        "lowest": np.zeros(found.shape),
        "highest": np.ones(found.shape),
        "needed": needed,
        "within_m": np.full(layers, 0.1),
        "permittivity": 5.0,
        "permittivity_range": (4.0, 6.0),
        "loss_tangent": 0.05,
        **{"seed": 0, "position": None},
    }
    return HidingMap(**{**values, **changes})
