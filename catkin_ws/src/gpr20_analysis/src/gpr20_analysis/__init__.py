"""Offline reading, checking, processing and imaging of GPR-20 surveys, without ROS.

The names in `__all__` are the public interface, shown in docs/reference/api.md. Each is loaded when
it is first used, so that importing this package is fast.
"""

from __future__ import annotations

import importlib
from typing import Any, Dict, List, Tuple

__version__ = "0.2.0"

_HOMES: Dict[str, Tuple[str, ...]] = {
    "candidates.answer": ("Answer", "answer", "field_options", "focus"),
    "candidates.files": ("read_hiding", "write_candidates", "write_hiding"),
    "candidates.search": ("Candidate", "CandidateList", "find_candidates"),
    "candidates.table": ("MarkerList", "candidate_lines", "survey_markers", "write_markers"),
    "dataset": ("Quality",),
    "errors": ("AnalysisError", "DamagedSurveyError"),
    "formats.dataset_files": ("cell_text", "write_dataset"),
    "formats.exports": ("export_survey",),
    "formats.imports": ("import_survey",),
    "hiding.search": ("Detector", "HidingOptions", "map_hidden"),
    "imaging.image": ("image_survey",),
    "imaging.image_options": (
        *("BuriedReference", "Ground", "ImageOptions", "Method", "Soils", "imaging_method"),
    ),
    "imaging.permittivity": ("permittivity_line",),
    "plotting.maps": (
        *("candidate_map_figure", "coverage_figure", "height_figure", "hiding_figure"),
        "projection_figure",
    ),
    "plotting.scans": ("a_scan_figure", "b_scan_figure", "c_scan_figure"),
    "processing.chain": ("process_survey",),
    "processing.delay": ("to_time",),
    "read.load": ("GrowingSurvey", "load_survey"),
    "read.verdict": ("Verification",),
    "read.verification": ("verify_survey",),
    "report.sections": ("write_report",),
    "report.summary": ("summarize",),
    "sample": ("sample_survey",),
    "sentences": ("message_of",),
}
__all__ = sorted(name for names in _HOMES.values() for name in names)


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(importlib.import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"gpr20_analysis has no '{name}'; it has {', '.join(__all__)}")


def __dir__() -> List[str]:
    return __all__
