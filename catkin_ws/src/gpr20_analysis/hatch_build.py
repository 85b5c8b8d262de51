"""Adds the parts of other packages that gpr20_analysis needs to its wheel, none of them ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NEEDED = ("gpr20_common", "gpr20_survey")
ROS = "high"


class NeededPackages(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the packages to the wheel, except to an editable installation.

    An editable installation finds them by `dev-mode-dirs`. Copies, which `force-include` in
    pyproject.toml would make there too, would come first on Python's path and hide later changes.
    """

    def initialize(self, version: str, build_data: Dict[str, Any]) -> None:
        """Add the files to the wheel."""
        if version == "editable":
            return
        for package in NEEDED:
            source = Path(self.root).parent / package / "src" / package
            for part in source.iterdir():
                if part.name not in (ROS, "__pycache__"):
                    build_data["force_include"][str(part)] = f"{package}/{part.name}"
