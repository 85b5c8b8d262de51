"""The parameters of the imaging node."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ImagingParameters:
    """Where the surveys are.

    Attributes:
        data: Folder of the surveys; empty: $GPR20_DATA, or ~/gpr20_data if that is not set.
    """

    data: str = ""

    def data_folder(self) -> Path:
        """Return where surveys are stored."""
        data = self.data.strip() or os.environ.get("GPR20_DATA", "") or "~/gpr20_data"
        return Path(data).expanduser().absolute()
