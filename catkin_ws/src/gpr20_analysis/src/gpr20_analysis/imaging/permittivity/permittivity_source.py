"""The permittivity of an image, from the best source that there is."""

from __future__ import annotations

from dataclasses import replace
from typing import Optional, Sequence

import xarray as xr

from gpr20_analysis.dataset import description_of
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.permittivity.buried_reference import permittivity_of_reference
from gpr20_analysis.imaging.permittivity.known_permittivity import KnownPermittivity, Source
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.antenna_step import ENDS, SURFACE_PERMITTIVITY
from gpr20_common.message import Message
from gpr20_survey.folder.soil_note import soil_of_survey
from gpr20_survey.radar.soils import ANY_SOIL, soil_of


def permittivity_of(
    survey: xr.Dataset, traces: Sequence[Traces], focus: Focus, options: ImageOptions
) -> KnownPermittivity:
    """Return the permittivity of an image, and how it is known.

    Args:
        survey: The survey; after the step `antenna` its surface gives a permittivity, else its
            plan or its log may.
        traces: Its traces, one item per polarization.
        focus: Window and antenna separation.
        options: What a person gave; without anything, and without that of surface and survey,
            any soil is assumed.

    Raises:
        WrongDatasetError: The buried reference does not give it.
    """
    measured = _of_surface(survey)
    given, share = options.permittivity, options.permittivity_uncertainty
    if given is not None:
        known = KnownPermittivity.within(given, share, Source.GIVEN)
    elif options.soil is not None:
        known = KnownPermittivity.of_soil(options.soil.value, Source.SOIL)
    elif options.buried is not None:
        known = permittivity_of_reference(traces, focus, options.buried)
    else:
        return measured or _of_survey(survey, share)
    if measured is None:
        return known
    if known.lowest <= measured.highest and measured.lowest <= known.highest:
        return known
    contradiction = Message(
        "the surface reflects like soil of permittivity {lowest:.3g} to {highest:.3g}, but the "
        "image is made with {used:.3g}",
        lowest=measured.lowest,
        highest=measured.highest,
        used=known.permittivity,
    )
    return replace(known, notes=(contradiction,))


def _of_survey(survey: xr.Dataset, share: float) -> KnownPermittivity:
    noted = soil_of_survey(description_of(survey))
    if noted is None:
        return KnownPermittivity.of_soil(ANY_SOIL, Source.ASSUMED)
    soil, source = soil_of(noted.permittivity), Source(noted.source)
    if soil is not None:
        return KnownPermittivity.of_soil(soil.value, source)
    return KnownPermittivity.within(noted.permittivity, share, source)


def _of_surface(survey: xr.Dataset) -> Optional[KnownPermittivity]:
    if SURFACE_PERMITTIVITY not in survey.attrs:
        return None
    lowest, best, highest = (float(survey.attrs[SURFACE_PERMITTIVITY + end]) for end in ENDS)
    return KnownPermittivity(best, lowest, highest, Source.SURFACE)
