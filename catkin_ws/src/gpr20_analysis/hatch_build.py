"""Puts the packages that gpr20_analysis stands on into its wheel; alone it needs them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

BENEATH = ("gpr20_common", "gpr20_survey")


class PackagesBeneath(BuildHookInterface):  # type: ignore[type-arg]
    """Takes them along, except when the sources run from where they are.

    An editable installation finds them by `dev-mode-dirs`. Copies would come first on Python's
    path, and stay as they were when the workspace changes.
    """

    def initialize(self, version: str, build_data: Dict[str, Any]) -> None:
        """Name what goes into the wheel."""
        if version == "editable":
            return
        for name in BENEATH:
            source = Path(self.root).parent / name / "src" / name
            build_data["force_include"][str(source)] = name
