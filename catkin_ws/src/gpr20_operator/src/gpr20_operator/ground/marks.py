"""What is marked on the pictures of the ground: candidates and markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from gpr20_operator.ground.model import Found, GroundModel
from gpr20_operator.ground.sources import Axis
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate

# What is nearer than this to a slice or section lies in it.
NEAR_MM = 25.0


@dataclass(frozen=True)
class GroundMark:
    """A candidate is a ring, a marker is a flag.

    Attributes:
        across_mm: Where it is along the first axis.
        second_mm: Where it is along the second axis: Y, or the depth.
        text: Inside of the ring.
        doubtful: Its ring is dashed.
        chosen: It is what the operator looks at.
        measured: Whether the ground there was measured; else the ring is grey and dashed.
        near: Whether it lies at what is shown; what does not is small and has no text.
        about: What a touch of it is about.
    """

    across_mm: float
    second_mm: float
    text: str
    is_flag: bool = False
    doubtful: bool = False
    chosen: bool = False
    measured: bool = True
    near: bool = True
    about: object = None


def marks_above(model: GroundModel) -> Tuple[GroundMark, ...]:
    """Return what is marked from above; what must not be overlooked comes last."""
    found = []
    for one in _marked(model):
        near = not model.has_depth or one.depth_mm is None or lies_at_depth(model, one)
        # A candidate that is not doubtful has its number at every depth.
        sure = isinstance(one, Candidate) and not one.is_doubtful
        found.append(_mark(model, one, one.x_mm, one.y_mm, near or sure or one == model.mark))
    return tuple(found)


def marks_in_section(model: GroundModel) -> Tuple[GroundMark, ...]:
    """Return what is marked in the section; what is far from it is left out."""
    along_x = model.settings.along is Axis.X_MM
    return tuple(
        _mark(model, one, one.x_mm if along_x else one.y_mm, one.depth_mm, True)
        for one in _marked(model)
        if one.depth_mm is not None and lies_in_section(model, one)
    )


def lies_at_depth(model: GroundModel, one: Found) -> bool:
    """Return whether a candidate or marker lies in the view from above."""
    depth_mm = model.settings.depth_m * 1000.0
    return one.depth_mm is not None and abs(one.depth_mm - depth_mm) <= NEAR_MM


def lies_in_section(model: GroundModel, one: Found) -> bool:
    """Return whether a candidate or marker lies in the section."""
    place, along_x = model.place, model.settings.along is Axis.X_MM
    if place is None:
        return False
    return abs(one.y_mm - place.y_mm if along_x else one.x_mm - place.x_mm) <= NEAR_MM


def _marked(model: GroundModel) -> Tuple[Found, ...]:
    """Return candidates and markers, those that must not be overlooked last."""
    found: Tuple[Found, ...] = (*model.additions.markers, *model.additions.candidates[::-1])
    last = sorted(
        found, key=lambda one: (one == model.mark, getattr(one, "is_doubtful", True) is False)
    )
    return tuple(last)


def _mark(
    model: GroundModel, one: Found, across_mm: float, second_mm: float, near: bool
) -> GroundMark:
    at_mm, chosen = (across_mm, second_mm), one == model.mark
    if isinstance(one, Marker):
        return GroundMark(*at_mm, "", is_flag=True, chosen=chosen, near=near, about=one)
    return GroundMark(
        *at_mm, str(one.number),
        doubtful=one.is_doubtful, chosen=chosen, near=near, about=one,
        measured=model.is_measured(one.x_mm, one.y_mm),
    )  # fmt: skip
