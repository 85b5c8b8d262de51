"""How far apart stops may be, so that a survey samples the echoes of the ground completely.

A quarter of the wavelength in the ground is the coarsest spacing that records reflections and
diffractions without aliasing: Grasmueck, Weger and Horstmeyer, "Full-resolution 3D GPR imaging",
Geophysics 70 (2005), K12 to K19.
"""

from __future__ import annotations

import math

from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.radar_processing import SPEED_OF_LIGHT_M_S

MM_PER_M = 1000.0


def quarter_wavelength_mm(parameters: SurveyParameters, permittivity: float) -> float:
    """Return c / (4 f sqrt(e)) at the centre frequency [mm].

    Args:
        parameters: Their frequencies.
        permittivity: Relative permittivity of the ground.
    """
    centre_hz = (parameters.start_frequency_hz + parameters.stop_frequency_hz) / 2.0
    return MM_PER_M * SPEED_OF_LIGHT_M_S / (4.0 * centre_hz * math.sqrt(permittivity))
