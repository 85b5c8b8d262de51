"""The kinds of network analyzers that the driver can use."""

from __future__ import annotations

from typing import Callable

from gpr20_vna_acquisition.low.visa_link import VisaLibrary, VisaLimits
from gpr20_vna_acquisition.mid.analyzer import Analyzer
from gpr20_vna_acquisition.mid.analyzer_kind import AnalyzerKind
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.foreign_analyzer import make_foreign_analyzer
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.scikit_rf_analyzer import ScikitRfAnalyzer
from gpr20_vna_acquisition.mid.scikit_rf_dialects import DIALECTS
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters


def make_analyzer(
    parameters: VnaParameters, connect_vxi11: Callable[[str], Transport], deadline: RequestDeadline
) -> Analyzer:
    """Return the analyzer that a robot is configured for.

    Args:
        parameters: The configuration.
        connect_vxi11: Opens a VXI-11 link to an address.
        deadline: Ends a request that takes too long.

    Raises:
        VnaLibraryError: A library that it needs is not installed.
        InvalidValueError: A class outside this software cannot be used.
    """
    if parameters.analyzer == AnalyzerKind.SCIKIT_RF.value:
        return _scikit_rf_analyzer(parameters, deadline)
    if parameters.analyzer != AnalyzerKind.MS2026C.value:
        return make_foreign_analyzer(parameters, deadline)
    return Ms2026c(connect_vxi11, parameters, deadline)


def _scikit_rf_analyzer(parameters: VnaParameters, deadline: RequestDeadline) -> Analyzer:
    # The parameters were checked: the class is there.
    assert parameters.scikit_rf_class is not None
    dialect = DIALECTS[parameters.scikit_rf_class]()
    limits = VisaLimits(
        connect_s=parameters.connect_timeout_s,
        answer_s=parameters.answer_timeout_s,
        clear=parameters.clear_on_connect,
    )
    library = VisaLibrary(
        parameters.scikit_rf_class.value, parameters.visa_library, limits, dialect.needs
    )
    return ScikitRfAnalyzer(library.connect, dialect, parameters, deadline)
