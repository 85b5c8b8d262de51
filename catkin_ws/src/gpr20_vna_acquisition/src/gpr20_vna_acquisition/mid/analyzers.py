"""The analyzer that a robot is configured for."""

from __future__ import annotations

from typing import Callable

from gpr20_vna_acquisition.mid.analyzer import DrivenAnalyzer
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.foreign_analyzer import make_foreign_analyzer
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C, VnaParameters


def make_analyzer(
    parameters: VnaParameters, connect_vxi11: Callable[[str], Transport], deadline: RequestDeadline
) -> DrivenAnalyzer:
    """Return the analyzer that a robot is configured for.

    Args:
        parameters: The configuration.
        connect_vxi11: Opens a VXI-11 link to an address.
        deadline: Ends a request that takes too long.

    Raises:
        InvalidValueError: A class outside this package cannot be used.
    """
    if parameters.analyzer != MS2026C:
        return make_foreign_analyzer(parameters, deadline)
    return Ms2026c(connect_vxi11, parameters, deadline)
