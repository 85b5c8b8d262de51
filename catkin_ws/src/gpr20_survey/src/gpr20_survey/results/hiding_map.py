"""Where a mine could hide: which share of synthetic targets the detector finds, by place and depth.

The analysis writes it as JSON, which every screen reads.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, List, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.codec import plain, record_from
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidates import SIMULATED
from gpr20_survey.results.hidden_target import Target

FORMAT = "gpr20-hiding/1"
MM_PER_M = 1e3
FLOATS = ("x_m", "y_m", "depth_m", "lowest", "highest", "within_m")
TABLES = {**dict.fromkeys(FLOATS, float), **dict.fromkeys(("tried", "found"), int)}
"""What is an array, and of what."""
SINGLE_CELL_M = 0.05
FEWEST = 6
"""Targets near a place; with fewer it counts as one where the target could hide."""
ONLY_THIS = Message(
    "This map holds for this target only. Where it was found, another object, or one that lies "
    "otherwise, may be missed."
)


@dataclass(frozen=True)
class HidingFacts:
    """What a map says beside its tables.

    Attributes:
        target: What was put into the spectra of the survey.
        needed: The share that must be found, else the target could hide.
        permittivity: Relative permittivity of the soil.
        permittivity_range: Its lowest and highest likely value.
        seed: Of the places that were tried.
        position: Where the area is on the earth; None: not known.
    """

    survey_id: str
    simulated: bool
    target: Target
    needed: float
    permittivity: float
    permittivity_range: Tuple[float, float]
    loss_tangent: float
    seed: int
    position: Optional[AreaPosition]


@dataclass(frozen=True)
class HidingMap(HidingFacts):
    """The share of targets that were found around places of a survey, with its 95 % interval.

    The axes ascend; the depth is that of the target's top.

    Attributes:
        tried: How many targets were put near each place (depth, y, x).
        found: How many of them the detector found.
        within_m: The targets of every place are at most so far from it, at each depth [m].
        notes: What else a person should know.
    """

    x_m: np.ndarray
    y_m: np.ndarray
    depth_m: np.ndarray
    tried: np.ndarray
    found: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    within_m: np.ndarray
    notes: Tuple[Message, ...] = ()

    def __post_init__(self) -> None:
        axes = (self.depth_m, self.y_m, self.x_m)
        tables = (self.tried, self.found, self.lowest, self.highest)
        shape = tuple(one.size for one in axes)
        ascending = all(one.ndim == 1 and one.size and np.all(np.diff(one) > 0.0) for one in axes)
        if not ascending or any(one.shape != shape for one in tables):
            raise ValueError("axes and tables contradict each other")
        if self.within_m.shape != shape[:1] or not np.all(self.within_m >= 0.0):
            raise ValueError("within_m is wrong")
        if np.any(self.found < 0) or np.any(self.found > self.tried):
            raise ValueError("more were found than tried")

    @property
    def share(self) -> np.ndarray:
        """The share that was found (depth, y, x); NaN where none was tried."""
        return np.divide(self.found, np.where(self.tried > 0, self.tried, np.nan))

    @property
    def missed(self) -> np.ndarray:
        """Whether the target could hide (depth, y, x): too few were found, or tried at all."""
        return np.logical_or(~(self.share >= self.needed), self.tried < FEWEST)

    @property
    def missed_m(self) -> np.ndarray:
        """The shallowest depth at which the target could hide (y, x) [m]; NaN: at none tried."""
        first = self.depth_m[np.argmax(self.missed, axis=0)]
        return np.where(np.any(self.missed, axis=0), first, np.nan)

    @property
    def sentences(self) -> List[Message]:
        """What the map says, for people; the warning that it holds for this target only first."""
        return [*([SIMULATED] if self.simulated else []), ONLY_THIS, *self.details]

    @property
    def cell_m(self) -> Tuple[float, float]:
        """Extent along X and Y of the cell around each place; of a line as wide as long [m]."""
        sizes = [float(np.ptp(one)) / max(len(one) - 1, 1) for one in (self.x_m, self.y_m)]
        known = [one for one in sizes if one > 0.0] or [SINGLE_CELL_M]
        return sizes[0] or min(known), sizes[1] or min(known)

    @property
    def details(self) -> List[Message]:
        """What the map says, without the warnings."""
        low, high = self.permittivity_range
        soil = Message(
            "soil: relative permittivity {low:.3g} to {high:.3g}, loss tangent {loss:g}",
            **{"low": low, "high": high, "loss": self.loss_tangent},
        )
        layers = [
            Message(
                "{depth_mm:.0f} mm deep: fewer than {fewest} targets were tried near each place, "
                "so nothing shows where one could not hide; try more rounds",
                depth_mm=MM_PER_M * depth_m,
                fewest=FEWEST,
            )
            if np.all(tried < FEWEST)
            else Message(
                "{depth_mm:.0f} mm deep: could hide on {percent:.0f} % of the map; of the "
                "targets within {within_mm:.0f} mm of a place {least:.0f} to {most:.0f} % were "
                "found",
                depth_mm=MM_PER_M * depth_m,
                percent=100.0 * float(np.mean(missed)),
                within_mm=MM_PER_M * within_m,
                least=100.0 * float(np.nan_to_num(share).min()),
                most=100.0 * float(np.nan_to_num(share).max()),
            )
            for depth_m, within_m, share, tried, missed in zip(
                self.depth_m, self.within_m, self.share, self.tried, self.missed
            )
        ]
        target = Message("target: {target}", target=self.target.sentence)
        return [target, soil, *layers, *self.notes]

    def at(self, x_m: float, y_m: float) -> Message:
        """Return what the map says of the place nearest to a position."""
        row, column = (
            int(np.argmin(np.abs(axis - place_m)))
            for axis, place_m in ((self.y_m, y_m), (self.x_m, x_m))
        )
        missed_mm, name = MM_PER_M * float(self.missed_m[row, column]), self.target.name
        if np.isnan(missed_mm):
            deepest_mm = MM_PER_M * self.depth_m[-1]
            return Message(
                "{name} found down to {deepest_mm:.0f} mm", name=name, deepest_mm=deepest_mm
            )
        return Message(
            "{name} could hide from {missed_mm:.0f} mm on", name=name, missed_mm=missed_mm
        )


def hiding_json(found: HidingMap) -> str:
    """Return a map as JSON."""
    values = {
        name: one.tolist() if isinstance(one, np.ndarray) else one
        for name, one in vars(found).items()
    }
    record = {
        "format": FORMAT,
        "warning": str(ONLY_THIS),
        **plain({**values, "notes": [str(note) for note in found.notes]}),
        "coordinates": "X, Y and depth of the top in metres, in the survey's area",
    }
    return json.dumps(record, ensure_ascii=False)


def hiding_from(text: str) -> HidingMap:
    """Return the map of a JSON text.

    Raises:
        InvalidValueError: Something is missing, or has another type or shape.
    """
    try:
        values = json.loads(text)
        if values["format"] != FORMAT:
            raise ValueError(f"the format is {values['format']!r}")
        notes = tuple(verbatim(str(one)) for one in values["notes"])
        facts = record_from(HidingFacts, values, "", others=True)
        tables: Any = {name: np.asarray(values[name], kind) for name, kind in TABLES.items()}
        return HidingMap(**vars(facts), **tables, notes=notes)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        message = Message("the map of hidden targets is not complete or not valid", details=error)
        raise InvalidValueError(message) from error
