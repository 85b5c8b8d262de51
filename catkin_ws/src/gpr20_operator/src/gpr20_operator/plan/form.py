"""What the operator plans: the texts of all fields of a survey, and their checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, FrozenSet, Iterable, Mapping, Optional, Set, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.plan.field_messages import corrections, field_title
from gpr20_operator.plan.parameter_form import (
    ADDRESS,
    FIELDS,
    FIELDS_BY_NAME,
    FormCheck,
    after_arrow,
    check_form,
    stepped,
    texts_of,
)
from gpr20_operator.plan.spacing import (
    length_from_texts,
    points_for,
    spacing_from_text,
    spacing_text,
)
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY, Soils

X_SPACING, Y_SPACING = "x_spacing_mm", "y_spacing_mm"
SPACINGS = (X_SPACING, Y_SPACING)
PERMITTIVITY = "permittivity"
PLAN_FIELDS: Tuple[str, ...] = (*(field.name for field in FIELDS), *SPACINGS, PERMITTIVITY)
TITLES: Mapping[str, Message] = {
    X_SPACING: Message("X spacing (mm)"),
    Y_SPACING: Message("Y spacing (mm)"),
    PERMITTIVITY: Message("Relative permittivity"),
}
_ABOVE_0 = Message("a number of millimetres above 0")
_PERMITTIVITIES = Message(
    "from {lower:g} to {upper:g}", lower=MIN_PERMITTIVITY, upper=MAX_PERMITTIVITY
)
FIELD_HINTS: Mapping[str, Message] = {
    X_SPACING: _ABOVE_0,
    Y_SPACING: _ABOVE_0,
    PERMITTIVITY: _PERMITTIVITIES,
}
# The arrows change a spacing within these bounds [mm].
SPACING_BOUNDS_MM = (1.0, 800.0)


@dataclass(frozen=True)
class PlanCheck:
    """The result of the checks of all fields.

    Attributes:
        form: Of the survey's parameters.
        permittivity: Relative permittivity of the ground; None if its text is wrong.
        problems: What each wrong field allows, by its name.
    """

    form: FormCheck
    permittivity: Optional[float]
    problems: Mapping[str, Message]

    @property
    def parameters(self) -> Optional[SurveyParameters]:
        """The survey's parameters; None if any field is wrong."""
        return None if self.problems else self.form.parameters


class PlanForm:
    """The texts of all fields. The points follow from the spacing, or the spacing from the points.

    Args:
        travel: What the axes allow.
    """

    def __init__(self, travel: RobotTravel) -> None:
        self.travel = travel
        self._texts: Dict[str, str] = {field.name: field.default for field in FIELDS}
        self._texts[PERMITTIVITY] = f"{Soils.DRY_SAND.value.permittivity:g}"
        self._following: Set[str] = set("xy")
        self._proposed_address = ""
        self._derive_spacings()

    @property
    def texts(self) -> Mapping[str, str]:
        """The text of each field by its name."""
        return self._texts

    @property
    def following(self) -> FrozenSet[str]:
        """The axes, x and y, whose number of points follows from the spacing."""
        return frozenset(self._following)

    def set_text(self, name: str, text: str) -> None:
        """Replace the text of a field, and with it what follows from it."""
        self._texts[name] = text
        axis = name[:1]
        if name in SPACINGS:
            self._following.add(axis)
            self._derive_points(axis)
        elif name in ("x_points", "y_points"):
            self._following.discard(axis)
            self._derive_spacings()
        elif name in ("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm"):
            if axis in self._following:
                self._derive_points(axis)
            else:
                self._derive_spacings()

    def set_texts(self, texts: Mapping[str, str]) -> None:
        """Replace the texts of several fields, in their order."""
        for name, text in texts.items():
            self.set_text(name, text)

    def restore(self, texts: Mapping[str, str], following: Iterable[str]) -> None:
        """Put the texts of an earlier time in place, without deriving one from the other."""
        self._texts.update(texts)
        self._following = set(following)

    def show_parameters(self, parameters: SurveyParameters) -> None:
        """Take over the parameters of a profile or of a survey; their spacing is kept."""
        self._texts.update(texts_of(parameters))
        self._following = set("xy")
        self._derive_spacings(all_axes=True)

    def propose_address(self, address: str) -> bool:
        """Take over the address of the robot's configuration, unless another one was entered.

        Returns:
            Whether the text has changed.
        """
        if address in ("", self._proposed_address):
            return False
        replaced = self._texts[ADDRESS] in ("", self._proposed_address)
        changed = replaced and self._texts[ADDRESS] != address
        if replaced:
            self._texts[ADDRESS] = address
        self._proposed_address = address
        return changed

    @property
    def proposed_address(self) -> str:
        """The address of the robot's configuration; empty if it is not known."""
        return self._proposed_address

    def restore_proposal(self, address: str) -> None:
        """Note which address was proposed when the texts were stored."""
        self._proposed_address = address

    def arrow(self, name: str, change: int) -> None:
        """Change the number of a field by an arrow, or choose its next value."""
        text = self._texts[name]
        if name in SPACINGS:
            changed = stepped(text, change, SPACING_BOUNDS_MM)
        elif name == PERMITTIVITY:
            changed = stepped(text, change, (MIN_PERMITTIVITY, MAX_PERMITTIVITY))
        else:
            changed = after_arrow(name, text, change, self.travel)
        self.set_text(name, changed)

    def normalize(self) -> None:
        """Write every text that can be read as it is read: 12,50 becomes 12.5."""
        for name, text in self._texts.items():
            try:
                if name in FIELDS_BY_NAME:
                    field = FIELDS_BY_NAME[name]
                    self._texts[name] = field.write(field.read(text))
                else:
                    self._texts[name] = f"{number_from_text(text):.12g}"
            except InvalidValueError:
                continue

    def check(self) -> PlanCheck:
        """Check all fields."""
        return check_plan(self._texts, self._following, self.travel)

    def _derive_points(self, axis: str) -> None:
        length_mm = length_from_texts(*self._ends(axis))
        spacing_mm = spacing_from_text(self._texts[f"{axis}_spacing_mm"])
        if length_mm is not None and spacing_mm is not None:
            self._texts[f"{axis}_points"] = str(points_for(length_mm, spacing_mm))

    def _derive_spacings(self, all_axes: bool = False) -> None:
        for axis in "xy":
            name = f"{axis}_spacing_mm"
            if all_axes or axis not in self._following or name not in self._texts:
                start, stop = self._ends(axis)
                self._texts[name] = spacing_text(start, stop, self._texts[f"{axis}_points"])

    def _ends(self, axis: str) -> Tuple[str, str]:
        return self._texts[f"{axis}_start_mm"], self._texts[f"{axis}_stop_mm"]


def check_plan(
    texts: Mapping[str, str], following: Iterable[str], travel: RobotTravel
) -> PlanCheck:
    """Check the texts of all fields.

    Args:
        texts: By the name of the field.
        following: The axes whose number of points follows from the spacing.
        travel: What the axes allow.
    """
    form = check_form(texts, travel)
    problems: Dict[str, Message] = dict(corrections(form, travel))
    for axis in following:
        if spacing_from_text(texts[f"{axis}_spacing_mm"]) is None:
            problems[f"{axis}_spacing_mm"] = _ABOVE_0
    permittivity = _permittivity(texts[PERMITTIVITY])
    if permittivity is None:
        problems[PERMITTIVITY] = _PERMITTIVITIES
    return PlanCheck(form, permittivity, problems)


def plan_field_title(name: str) -> Message:
    """Return what a field is called."""
    return TITLES[name] if name in TITLES else field_title(name)


def _permittivity(text: str) -> Optional[float]:
    try:
        value = number_from_text(text)
    except InvalidValueError:
        return None
    return value if MIN_PERMITTIVITY <= value <= MAX_PERMITTIVITY else None
