"""Which survey something belongs to."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import FREQUENCY, POLARIZATION, S21, S21_DIMS, X, Y, require


@dataclass(frozen=True)
class SurveyIdentity:
    """Which survey picks belong to.

    Attributes:
        survey_id: Identifier of the survey; empty if the data have none.
        sha256: Of the positions and spectra that were loaded.
        simulated: Whether the survey was made by the simulated robot.
    """

    survey_id: str
    sha256: str
    simulated: bool

    @staticmethod
    def of(survey: xr.Dataset) -> SurveyIdentity:
        """Return the identity of a survey that is in memory."""
        digest = hashlib.sha256()
        for name in (POLARIZATION, Y, X, FREQUENCY):
            digest.update(np.ascontiguousarray(survey[name].values, dtype="<f8").tobytes())
        for values in require(survey, S21, S21_DIMS).values:
            digest.update(np.ascontiguousarray(values, dtype="<c16").data)
        return SurveyIdentity(
            str(survey.attrs.get("survey_id", "")),
            digest.hexdigest(),
            bool(survey.attrs.get("simulated")),
        )
