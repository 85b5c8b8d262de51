"""What the fields are called, what they allow, and what is wrong, in the operator's language."""

from __future__ import annotations

from typing import Dict

from PyQt5.QtCore import QCoreApplication

from gpr20_survey.plan.survey_parameters import MAX_TRACES, RobotTravel, Rule
from gpr20_user_interface.mid.parameter_form import ADDRESS, ROTATIONS, FormCheck, limits

# Fields of one number that need not be whole.
DECIMALS = frozenset(
    name.format(end=end)
    for name in ("{end}_frequency_hz", "x_{end}_mm", "y_{end}_mm")
    for end in ("start", "stop")
)


def field_title(name: str) -> str:
    """Return what a field is called."""
    translate = QCoreApplication.translate
    return {
        ADDRESS: translate("Fields", "VNA address"),
        "start_frequency_hz": translate("Fields", "Start frequency (MHz)"),
        "stop_frequency_hz": translate("Fields", "Stop frequency (MHz)"),
        "frequency_points": translate("Fields", "Frequency points"),
        "x_start_mm": translate("Fields", "X start (mm)"),
        "x_stop_mm": translate("Fields", "X stop (mm)"),
        "x_points": translate("Fields", "X points"),
        "y_start_mm": translate("Fields", "Y start (mm)"),
        "y_stop_mm": translate("Fields", "Y stop (mm)"),
        "y_points": translate("Fields", "Y points"),
        ROTATIONS: translate("Fields", "Antenna rotations (°)"),
    }[name]


def allowed_text(name: str, travel: RobotTravel) -> str:
    """Return what a field allows."""
    translate = QCoreApplication.translate
    if name == ADDRESS:
        return translate("Fields", "four whole numbers from 0 to 255")
    if name == ROTATIONS:
        return translate(
            "Fields",
            "different rotations from {lower} to {upper}, each a multiple of {step}, with commas",
        ).format(
            lower=f"{travel.z.lower:g}", upper=f"{travel.z.upper:g}", step=f"{travel.z.step:g}"
        )
    lower, upper = limits(name, travel)
    if name in ("x_points", "y_points"):
        return translate("Fields", "a whole number, {lower} or more").format(lower=lower)
    if name == "frequency_points":
        text = translate("Fields", "a whole number from {lower} to {upper}")
    elif name == "start_frequency_hz":
        text = translate("Fields", "from {lower} to {upper}, below the stop frequency")
    else:
        text = translate("Fields", "from {lower} to {upper}")
    return text.format(lower=f"{lower:g}", upper=f"{upper:g}")


def wrong_texts(check: FormCheck, travel: RobotTravel) -> Dict[str, str]:
    """Return for each field that is wrong what it allows."""
    return {name: _wrong_text(name, check, travel) for name in check.wrong_fields}


def field_problems(check: FormCheck, travel: RobotTravel) -> Dict[str, str]:
    """Return a sentence for each field that is wrong."""
    sentence = QCoreApplication.translate("Fields", "{field}: {allowed}")
    return {
        name: sentence.format(field=field_title(name), allowed=allowed)
        for name, allowed in wrong_texts(check, travel).items()
    }


def _wrong_text(name: str, check: FormCheck, travel: RobotTravel) -> str:
    allowed = _spacing(name, check, travel) or _size(name, check) or allowed_text(name, travel)
    if name in check.unreadable and name in DECIMALS:
        # Many a keyboard and country writes 12,5.
        return QCoreApplication.translate("Fields", "a number such as 12.5, {allowed}").format(
            allowed=allowed
        )
    return allowed


def _spacing(name: str, check: FormCheck, travel: RobotTravel) -> str:
    rules = {"x_points": (Rule.X_SPACING, travel.x), "y_points": (Rule.Y_SPACING, travel.y)}
    if name not in rules or rules[name][0] not in check.broken:
        return ""
    return QCoreApplication.translate(
        "Fields", "the points between start and stop must be at least {step} mm apart"
    ).format(step=f"{rules[name][1].step:g}")


def _size(name: str, check: FormCheck) -> str:
    if name not in ("x_points", "y_points") or Rule.SIZE not in check.broken:
        return ""
    return QCoreApplication.translate("Fields", "fewer, a survey has at most {most} traces").format(
        most=MAX_TRACES
    )
