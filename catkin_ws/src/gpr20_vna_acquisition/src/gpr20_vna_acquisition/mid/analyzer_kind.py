"""The kinds of network analyzers that the driver can control."""

from __future__ import annotations

import enum


class AnalyzerKind(enum.Enum):
    """The implementations of `Analyzer` in this package."""

    MS2026C = "ms2026c"
    SCIKIT_RF = "scikit_rf"


class ScikitRfClass(enum.Enum):
    """The classes of scikit-rf that are adapted, as named below `skrf.vi.vna`."""

    PNA = "keysight.PNA"
    FIELDFOX = "keysight.FieldFox"
    ZVA = "rohde_schwarz.ZVA"
    ZNA = "rohde_schwarz.ZNA"
