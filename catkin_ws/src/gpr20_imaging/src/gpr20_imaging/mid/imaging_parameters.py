"""The parameters of the imaging node."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from gpr20_common.low.data_folder import data_folder


@dataclass(frozen=True)
class ImagingParameters:
    """Where the surveys are.

    Attributes:
        data: Folder of the surveys; empty: $GPR20_DATA, or ~/gpr20_data if that is not set.
    """

    data: str = ""

    def data_folder(self) -> Path:
        """Return where surveys are stored."""
        return data_folder(self.data, os.environ)
