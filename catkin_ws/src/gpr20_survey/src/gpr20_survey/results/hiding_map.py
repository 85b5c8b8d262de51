"""Where a mine could hide: which share of synthetic targets the detector finds, by place and depth.

The analysis writes it as JSON, which every screen reads.
"""

from __future__ import annotations

import enum
import json
from dataclasses import dataclass
from typing import Any, List, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import plain, record_from
from gpr20_survey.results.candidates import SIMULATED, AreaPosition

MM_PER_M = 1e3
SMALLEST_MM, LARGEST_MM, HIGHEST = 5.0, 400.0, 100.0
MOST_SHOWN = 40
EXPLOSIVE = 2.8
"""Relative permittivity of a plastic mine: that of TNT, which fills most of it, is 2.7 to 2.9."""


@dataclass(frozen=True)
class Target:
    """A level disc of plastic, or a ball of metal.

    Attributes:
        height_m: Its height [m]; of a ball its diameter.
        permittivity: Its relative permittivity; None: it is metal.
    """

    name: str
    diameter_m: float
    height_m: float
    permittivity: Optional[float] = None

    def __post_init__(self) -> None:
        for name, size_m in (("diameter", self.diameter_m), ("height", self.height_m)):
            number_between(name, MM_PER_M * size_m, SMALLEST_MM, LARGEST_MM, "mm")
        if self.permittivity is not None:
            number_between("permittivity", self.permittivity, 1.0, HIGHEST)

    @property
    def is_metal(self) -> bool:
        return self.permittivity is None

    @property
    def sentence(self) -> Message:
        diameter_mm, height_mm = MM_PER_M * self.diameter_m, MM_PER_M * self.height_m
        if self.is_metal:
            return Message("a metal ball of {diameter_mm:g} mm", diameter_mm=diameter_mm)
        return Message(
            "a plastic disc of {diameter_mm:g} mm, {height_mm:g} mm high, relative permittivity "
            "{permittivity:g}",
            diameter_mm=diameter_mm,
            height_mm=height_mm,
            permittivity=self.permittivity,
        )


class Targets(enum.Enum):
    """Targets with a name. The sizes of the mines are those of their data sheets."""

    PMN = Target("pmn", 0.112, 0.056, EXPLOSIVE)
    TYPE_72 = Target("type-72", 0.078, 0.038, EXPLOSIVE)
    FRAGMENT = Target("fragment", 0.020, 0.020)


def target_of(text: str) -> Target:
    """Return a target from its name, or from disc:DIAMETER:HEIGHT:PERMITTIVITY or ball:DIAMETER.

    Args:
        text: Sizes are in mm.

    Raises:
        InvalidValueError: It is none of these, or a value is not allowed.
    """
    named = {one.value.name: one.value for one in Targets}
    if text in named:
        return named[text]
    kind, *sizes = text.split(":")
    try:
        numbers = [float(one) for one in sizes]
    except ValueError:
        numbers = []
    if (kind, len(numbers)) == ("disc", 3):
        diameter_mm, height_mm, permittivity = numbers
        return Target(text[:MOST_SHOWN], diameter_mm / MM_PER_M, height_mm / MM_PER_M, permittivity)
    if (kind, len(numbers)) == ("ball", 1):
        return Target(text[:MOST_SHOWN], numbers[0] / MM_PER_M, numbers[0] / MM_PER_M)
    raise InvalidValueError(
        Message(
            "the target is '{text}'; use {names}, disc:DIAMETER:HEIGHT:PERMITTIVITY or "
            "ball:DIAMETER, sizes in mm, such as disc:80:35:2.8",
            text=text[:MOST_SHOWN],
            names=", ".join(named),
        )
    )


FORMAT = "gpr20-hiding/1"
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
