"""The figures of a survey in words."""

from __future__ import annotations

from typing import List, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_user_interface.mid.parameter_form import HERTZ_PER_MEGAHERTZ
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.mid.time_words import duration

UNKNOWN = verbatim("—")
BYTES_PER_MEGABYTE = 1.0e6
MILLIMETRES_PER_METRE = 1000.0
SPACING = Message("Spacing X, Y")
TITLES = (
    Message("Traces"),
    Message("Stops"),
    Message("Estimated time"),
    Message("Disk space"),
    SPACING,
    Message("λ/4 in soil"),
    Message("Depth in soil"),
    Message("Resolution in soil"),
    Message("Frequency step"),
    Message("Traces per stop"),
)


def figure_texts(preview: Optional[SurveyPreview]) -> List[Tuple[Message, Message]]:
    """Return title and text of each figure.

    Args:
        preview: Of the survey; None while its parameters are wrong.
    """
    texts = (UNKNOWN,) * len(TITLES) if preview is None else _texts(preview)
    return list(zip(TITLES, texts))


def spacing_warning(preview: Optional[SurveyPreview]) -> Optional[Message]:
    """Return the warning that the stops are too far apart for the soil; None if they are not."""
    if preview is None or not preview.too_coarse:
        return None
    return Message(
        "Spacing {spacing:.4g} mm is more than λ/4 = {quarter:.3g} mm in this soil: the image may "
        "miss or double targets",
        spacing=max(preview.x_spacing_mm, preview.y_spacing_mm),
        quarter=preview.quarter_wavelength_mm,
    )


def short_warning(preview: Optional[SurveyPreview]) -> Optional[Message]:
    """Return the same warning in a few words."""
    if preview is None or not preview.too_coarse:
        return None
    return Message(
        "Spacing {spacing:.4g} mm > λ/4 {quarter:.3g} mm",
        spacing=max(preview.x_spacing_mm, preview.y_spacing_mm),
        quarter=preview.quarter_wavelength_mm,
    )


def short_figures(preview: Optional[SurveyPreview]) -> Tuple[Message, Message]:
    """Return the most important figures in two lines."""
    if preview is None:
        return UNKNOWN, verbatim("")
    cost = preview.cost
    size = Message("{traces} traces", traces=preview.traces)
    if cost is not None:
        size = Message(
            "{traces} traces, {time}", traces=preview.traces, time=duration(cost.duration_s)
        )
    depth = Message(
        "Depth {depth:.3g} m, resolution {resolution:.3g} mm",
        depth=preview.depth_m,
        resolution=preview.resolution_m * MILLIMETRES_PER_METRE,
    )
    return size, depth


def _texts(preview: SurveyPreview) -> Tuple[Message, ...]:
    cost = preview.cost
    return (
        verbatim(f"{preview.traces}"),
        verbatim(f"{preview.stops}"),
        UNKNOWN if cost is None else duration(cost.duration_s),
        UNKNOWN if cost is None else verbatim(f"{cost.size_bytes / BYTES_PER_MEGABYTE:.4g} MB"),
        verbatim(f"{preview.x_spacing_mm:.4g}, {preview.y_spacing_mm:.4g} mm"),
        verbatim(f"{preview.quarter_wavelength_mm:.3g} mm"),
        verbatim(f"{preview.depth_m:.3g} m"),
        verbatim(f"{preview.resolution_m * MILLIMETRES_PER_METRE:.3g} mm"),
        verbatim(f"{preview.frequency_step_hz / HERTZ_PER_MEGAHERTZ:.4g} MHz"),
        verbatim(f"{preview.traces // preview.stops}"),
    )
