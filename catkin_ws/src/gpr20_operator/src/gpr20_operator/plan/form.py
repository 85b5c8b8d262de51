"""What the operator plans: the texts of all fields and their checks, figures, and names."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any, Dict, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.fields import (
    PARAMETERS,
    PEOPLE,
    PLAN,
    SPECS,
    FieldSpec,
    Keys,
    default_parameters,
    texts_of,
)
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import (
    MIN_GRID_POINTS,
    Relation,
    RobotTravel,
    SurveyParameters,
    find_problems,
)
from gpr20_survey.plan.survey_points import SurveyCost
from gpr20_survey.radar import one_way_path_m

# Of a text in a sheet, which has no room for more.
LONGEST_SHOWN = 30
# Of a spacing; a derived spacing is shown with six digits.
ROUNDING = 1.0e-5
# Of an axis; the checks limit the size of the whole survey.
MAX_INTERVALS = 9999
# What an axis has on the form, in the place of the number of its points.
SPACINGS = {"x_points": "x_spacing_mm", "y_points": "y_spacing_mm"}


@dataclass(frozen=True)
class PlanCheck:
    """What the texts say, None where one is wrong, and what each wrong field allows."""

    parameters: Optional[SurveyParameters]
    permittivity: Optional[float]
    problems: Mapping[str, Message]

    def problem_of(self, name: str) -> Message:
        """Return what a wrong field is called, and what it allows."""
        return Message("{field}: {allowed}", field=SPECS[name].title, allowed=self.problems[name])


def _unreadable(spec: FieldSpec, text: str, travel: RobotTravel) -> Message:
    if spec.kind.keys is not Keys.NUMBER or _finite(text) is not None:
        return spec.allowed(travel)
    # Many a keyboard and country writes 12,5.
    return Message("a number such as 12.5")


class PlanForm:
    """The texts of all fields; the number of points of an axis follows from its spacing."""

    def __init__(self, travel: RobotTravel) -> None:
        self.travel = travel
        self._texts: Dict[str, str] = {spec.name: spec.default for spec in PLAN}

    @property
    def texts(self) -> Mapping[str, str]:
        """The text of each field by its name."""
        return self._texts

    def set_text(self, name: str, text: str) -> None:
        """Replace the text of a field, and with it what follows from it."""
        texts, axis = self._texts, name.partition("_")[0]
        texts[name] = text
        if axis in ("x", "y"):
            length_mm, spacing_mm = self._length_mm(axis), _finite(texts[f"{axis}_spacing_mm"])
            if length_mm is not None and spacing_mm is not None and spacing_mm > 0.0:
                texts[f"{axis}_points"] = str(points_for(length_mm, spacing_mm))

    def set_texts(self, texts: Mapping[str, str]) -> None:
        """Replace the texts of several fields, in their order."""
        for name, text in texts.items():
            self.set_text(name, text)

    def restore(self, texts: Mapping[str, str]) -> None:
        """Put the texts of an earlier time in place."""
        self._texts.update(texts)

    def show_parameters(self, parameters: SurveyParameters) -> None:
        """Take over the parameters of a survey; their spacing is kept."""
        self._texts.update(texts_of(parameters))
        for axis, points in (("x", parameters.x_points), ("y", parameters.y_points)):
            length_mm = self._length_mm(axis)
            spacing = "" if length_mm is None or points < 2 else f"{length_mm / (points - 1):.6g}"
            self._texts[f"{axis}_spacing_mm"] = spacing

    def check(self) -> PlanCheck:
        """Check all fields."""
        texts, travel = self._texts, self.travel
        values: Dict[str, Any] = {}
        problems: Dict[str, Message] = {}
        for spec in PLAN:
            try:
                values[spec.name] = spec.kind.read(texts[spec.name])
            except InvalidValueError:
                problems[spec.name] = _unreadable(spec, texts[spec.name], travel)
        unreadable = [one.name for one in PARAMETERS if one.name not in values]
        known = {one.name: values[one.name] for one in PARAMETERS if one.name in values}
        candidate = replace(default_parameters(), **known)
        # What cannot be read has its default, which must not be judged, nor what follows from it.
        for found in find_problems(candidate, travel):
            related = isinstance(found.of, Relation)
            if found.of in unreadable or (unreadable and related):
                continue
            own = not related or found.of is Relation.FREQUENCY_ORDER
            for name in found.of.value if isinstance(found.of, Relation) else (found.of,):
                said = SPECS[name].allowed(travel) if own else found.message
                problems.setdefault(SPACINGS.get(name, name), said)
        in_order = {one.name: problems[one.name] for one in PLAN if one.name in problems}
        return PlanCheck(None if in_order else candidate, values.get("permittivity"), in_order)

    def _length_mm(self, axis: str) -> Optional[float]:
        ends = (self._texts[f"{axis}_{end}_mm"] for end in ("start", "stop"))
        start_mm, stop_mm = map(_finite, ends)
        return None if start_mm is None or stop_mm is None else abs(stop_mm - start_mm)


def points_for(length_mm: float, spacing_mm: float) -> int:
    """Return the fewest points along a length that are no farther apart than a spacing."""
    intervals = length_mm / (spacing_mm * (1.0 + ROUNDING))
    return max(MIN_GRID_POINTS, math.ceil(min(intervals, MAX_INTERVALS)) + 1)


def _finite(text: str) -> Optional[float]:
    try:
        return number_from_text(text)
    except InvalidValueError:
        return None


@dataclass(frozen=True)
class SurveyPreview:
    """Figures of a survey.

    Attributes:
        stops: Number of places.
        traces: Number of traces, one per stop and polarization.
        x_spacing_mm: Distance of two stops of a line [mm].
        y_spacing_mm: Distance of two lines [mm].
        quarter_wavelength_mm: Coarsest spacing that samples the echoes completely [mm].
        cost: Time and disk space; None while the robot's own figures are not known.
    """

    stops: int
    traces: int
    x_spacing_mm: float
    y_spacing_mm: float
    quarter_wavelength_mm: float
    cost: Optional[SurveyCost] = None

    @property
    def too_coarse(self) -> bool:
        """Whether stops are farther apart than a quarter wavelength."""
        widest_mm = max(self.x_spacing_mm, self.y_spacing_mm)
        return widest_mm > self.quarter_wavelength_mm * (1.0 + ROUNDING)


def quarter_wavelength_mm(parameters: SurveyParameters, permittivity: float) -> float:
    """Return the coarsest spacing that samples the echoes of the ground completely [mm].

    Grasmueck, Weger and Horstmeyer, "Full-resolution 3D GPR imaging", Geophysics 70 (2005), K12 to
    K19.
    """
    centre_hz = (parameters.start_frequency_hz + parameters.stop_frequency_hz) / 2.0
    return 1000.0 * one_way_path_m(1.0 / centre_hz, permittivity) / 2.0


def preview(parameters: SurveyParameters, permittivity: float) -> SurveyPreview:
    """Return what follows from the parameters alone; they must have passed the checks."""
    p = parameters
    return SurveyPreview(
        stops=p.x_points * p.y_points,
        traces=p.total_points,
        x_spacing_mm=abs(p.x_stop_mm - p.x_start_mm) / (p.x_points - 1),
        y_spacing_mm=abs(p.y_stop_mm - p.y_start_mm) / (p.y_points - 1),
        quarter_wavelength_mm=quarter_wavelength_mm(parameters, permittivity),
    )


@dataclass(frozen=True)
class CostEstimated:
    """Time and disk space of a survey with given parameters."""

    parameters: SurveyParameters
    cost: SurveyCost


def annotation_texts(annotation: Annotation) -> Dict[str, str]:
    """Return the text of each field."""
    return {one.name: one.kind.write(getattr(annotation, one.name)) for one in PEOPLE}


def annotation_from(texts: Mapping[str, str]) -> Annotation:
    """Return what the texts of all fields say.

    Raises:
        InvalidValueError: One is not allowed.
    """
    return Annotation(**{one.name: one.kind.read(texts[one.name]) for one in PEOPLE})


def overwritten(before: Annotation, after: Annotation) -> Tuple[Tuple[Message, Message], ...]:
    """Return what changes, with the old and the new text from where they differ."""
    rows = []
    texts = annotation_texts(before).values(), annotation_texts(after).values()
    for spec, old, new in zip(PEOPLE, *texts):
        same = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(old, new)))
        if old != new and same >= LONGEST_SHOWN - 2:
            old, new = (f"…{text[same - LONGEST_SHOWN // 3 :]}" for text in (old, new))
        if old != new:
            rows.append((spec.title, verbatim(f"{shortened(old)} → {shortened(new)}")))
    return tuple(rows)


def shortened(text: str) -> str:
    """Return as much of a text as a sheet has room for, as one line; a dash if it is empty."""
    line = " ".join(text.split()) or "—"
    return line if len(line) <= LONGEST_SHOWN else line[: LONGEST_SHOWN - 1] + "…"
