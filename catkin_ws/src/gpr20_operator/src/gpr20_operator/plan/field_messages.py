"""What the fields are called, what they allow, and what is wrong with them."""

from __future__ import annotations

from typing import Dict, Mapping, Optional

from gpr20_common.message import Message
from gpr20_operator.plan.parameter_form import (
    ADDRESS,
    AVERAGES,
    IF_BANDWIDTH,
    OUTPUT_POWER,
    ROTATIONS,
    FormCheck,
    limits,
)
from gpr20_survey.plan.survey_parameters import (
    MAX_IF_BANDWIDTH_HZ,
    MAX_TRACES,
    MIN_IF_BANDWIDTH_HZ,
    RobotTravel,
    Rule,
)
from gpr20_survey.trace.ms2026c import MAX_AVERAGES, MIN_FREQUENCY_SPACING_HZ

# Fields of one number that need not be whole.
DECIMALS = frozenset(
    name.format(end=end)
    for name in ("{end}_frequency_hz", "x_{end}_mm", "y_{end}_mm")
    for end in ("start", "stop")
)
_TITLES: Mapping[str, Message] = {
    ADDRESS: Message("VNA address"),
    "start_frequency_hz": Message("Start frequency (MHz)"),
    "stop_frequency_hz": Message("Stop frequency (MHz)"),
    "frequency_points": Message("Frequency points"),
    "x_start_mm": Message("X start (mm)"),
    "x_stop_mm": Message("X stop (mm)"),
    "x_points": Message("X points"),
    "y_start_mm": Message("Y start (mm)"),
    "y_stop_mm": Message("Y stop (mm)"),
    "y_points": Message("Y points"),
    ROTATIONS: Message("Antenna rotations (°)"),
    IF_BANDWIDTH: Message("IF bandwidth (Hz)"),
    AVERAGES: Message("Averages"),
    OUTPUT_POWER: Message("Output power"),
}


def field_title(name: str) -> Message:
    """Return what a field is called."""
    return _TITLES[name]


def allowed_values(name: str, travel: RobotTravel) -> Message:
    """Return what a field allows."""
    if name == ADDRESS:
        return Message("four whole numbers from 0 to 255")
    if name == IF_BANDWIDTH:
        return Message(
            "empty: as set on the VNA; else {lower:g} to {upper:g}",
            lower=MIN_IF_BANDWIDTH_HZ,
            upper=MAX_IF_BANDWIDTH_HZ,
        )
    if name == AVERAGES:
        return Message(
            "empty: as set on the VNA; else a whole number from 1 to {upper}", upper=MAX_AVERAGES
        )
    if name == OUTPUT_POWER:
        return Message("empty: as set on the VNA; the MS2026C has LOW and HIGH")
    if name == ROTATIONS:
        return Message(
            "different rotations from {lower:g} to {upper:g}, each a multiple of {step:g}, "
            "separated by commas",
            lower=travel.z.lower,
            upper=travel.z.upper,
            step=travel.z.step,
        )
    lower, upper = limits(name, travel)
    if name in ("x_points", "y_points"):
        return Message("a whole number, {lower:g} or more", lower=lower)
    if name == "frequency_points":
        return Message("a whole number from {lower:g} to {upper:g}", lower=lower, upper=upper)
    if name == "start_frequency_hz":
        return Message(
            "from {lower:g} to {upper:g}, below the stop frequency", lower=lower, upper=upper
        )
    return Message("from {lower:g} to {upper:g}", lower=lower, upper=upper)


def corrections(check: FormCheck, travel: RobotTravel) -> Dict[str, Message]:
    """Return for each field that is wrong what it allows."""
    return {name: _correction(name, check, travel) for name in check.wrong_fields}


def _correction(name: str, check: FormCheck, travel: RobotTravel) -> Message:
    allowed = _spacing(name, check, travel) or _size(name, check) or allowed_values(name, travel)
    if name in check.unreadable and name in DECIMALS:
        # Many a keyboard and country writes 12,5.
        return Message("a number such as 12.5, {allowed}", allowed=allowed)
    return allowed


def _spacing(name: str, check: FormCheck, travel: RobotTravel) -> Optional[Message]:
    if name == "frequency_points" and Rule.FREQUENCY_SPACING in check.broken:
        return Message(
            "the frequencies must be at least {least:g} Hz apart", least=MIN_FREQUENCY_SPACING_HZ
        )
    rules = {"x_points": (Rule.X_SPACING, travel.x), "y_points": (Rule.Y_SPACING, travel.y)}
    if name not in rules or rules[name][0] not in check.broken:
        return None
    return Message(
        "the points between start and stop must be at least {step:g} mm apart",
        step=rules[name][1].step,
    )


def _size(name: str, check: FormCheck) -> Optional[Message]:
    if name not in ("x_points", "y_points") or Rule.SIZE not in check.broken:
        return None
    return Message("at most {most} traces per survey", most=MAX_TRACES)
