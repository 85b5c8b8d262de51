"""The parameters of a survey as texts in fields, and what is wrong with them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from gpr20_main_control.mid.survey_parameters import RobotTravel, SurveyParameters, problems
from gpr20_user_interface.mid.units import hertz_from_megahertz, rotations_from_text


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"'{text}' is not a whole number") from None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"'{text}' is not a number") from None


@dataclass(frozen=True)
class Field:
    """One field of the form.

    Args:
        name: Field of SurveyParameters.
        sentence_start: How the sentences about it begin that come from the checks.
        default: Text that the field starts with.
        read: Makes the parameter's value from the text, or raises ValueError.
    """

    name: str
    sentence_start: str
    default: str
    read: Callable[[str], Any]


FIELDS: Tuple[Field, ...] = (
    Field("vna_address", "VNA address", "127.0.0.1", str.strip),
    Field("start_frequency_hz", "start frequency", "600", hertz_from_megahertz),
    Field("stop_frequency_hz", "stop frequency", "6000", hertz_from_megahertz),
    Field("frequency_points", "frequency points", "501", _whole_number),
    Field("x_start_mm", "x start", "50", _number),
    Field("x_stop_mm", "x stop", "150", _number),
    Field("x_points", "x points", "5", _whole_number),
    Field("y_start_mm", "y start", "50", _number),
    Field("y_stop_mm", "y stop", "150", _number),
    Field("y_points", "y points", "5", _whole_number),
    Field("polarizations_deg", "polarization", "0, 90", rotations_from_text),
)


@dataclass(frozen=True)
class FormCheck:
    """What the texts of the form amount to.

    Args:
        parameters: None if a text cannot be read or a value is not allowed.
        field_problems: One sentence per field that is wrong.
        other_problems: Sentences about more than one field.
    """

    parameters: Optional[SurveyParameters]
    field_problems: Mapping[str, str]
    other_problems: Tuple[str, ...] = ()

    @property
    def sentences(self) -> Tuple[str, ...]:
        """Every sentence, in the order of the fields."""
        return (*self.field_problems.values(), *self.other_problems)


def check_form(texts: Mapping[str, str], travel: RobotTravel) -> FormCheck:
    """Read and check the texts of all fields."""
    values: Dict[str, Any] = {}
    unreadable: Dict[str, str] = {}
    for field in FIELDS:
        try:
            values[field.name] = field.read(texts[field.name])
        except ValueError as error:
            unreadable[field.name] = f"{field.sentence_start}: {error}"
    candidate = _completed(values)
    # A field that cannot be read stands in with its default, which must not be judged.
    found = [one for one in problems(candidate, travel) if not _is_about(one, unreadable)]
    by_field, others = _assigned(found)
    by_field.update(unreadable)
    ordered = {field.name: by_field[field.name] for field in FIELDS if field.name in by_field}
    good = candidate if not ordered and not others else None
    return FormCheck(good, ordered, tuple(others))


def _completed(values: Mapping[str, Any]) -> SurveyParameters:
    defaults = {field.name: field.read(field.default) for field in FIELDS}
    return dataclasses.replace(SurveyParameters(**defaults), **values)


def _is_about(sentence: str, names: Mapping[str, str]) -> bool:
    return any(
        field.name in names and sentence.startswith(field.sentence_start) for field in FIELDS
    )


def _assigned(sentences: List[str]) -> Tuple[Dict[str, str], List[str]]:
    by_field: Dict[str, str] = {}
    others: List[str] = []
    for sentence in sentences:
        for field in FIELDS:
            if sentence.startswith(field.sentence_start):
                by_field.setdefault(field.name, sentence)
                break
        else:
            others.append(sentence)
    return by_field, others
