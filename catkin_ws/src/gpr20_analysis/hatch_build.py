"""Puts what gpr20_analysis needs of the workspace into its wheel: no ROS is among it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NEEDED = {
    "gpr20_survey": [""],
    "gpr20_common": [
        *("__init__.py", "catalogue.py", "errors.py", "message.py", "os_reason.py"),
        *("low", "mid", "translations"),
    ],
}


class NeededPackages(BuildHookInterface):  # type: ignore[type-arg]
    """Takes them along, except when the sources run from where they are.

    An editable installation finds them by `dev-mode-dirs`. Copies, which `force-include` of
    pyproject.toml would make there too, come first on Python's path and hide later changes.
    """

    def initialize(self, version: str, build_data: Dict[str, Any]) -> None:
        """Name what goes into the wheel."""
        if version == "editable":
            return
        for package, parts in NEEDED.items():
            source = Path(self.root).parent / package / "src" / package
            for part in parts:
                build_data["force_include"][str(source / part)] = f"{package}/{part}".rstrip("/")
