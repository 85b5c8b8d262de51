"""What installed packages add to gpr20 by entry points; finding it imports nothing of theirs."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from typing import Any, Dict, List, Tuple


@dataclass(frozen=True)
class Addition:
    """An entry point of an installed package.

    Attributes:
        entry: The entry point.
        package: The package's name and version.
        summary: The package's summary.
    """

    entry: metadata.EntryPoint
    package: str
    summary: str

    @property
    def name(self) -> str:
        """Its name."""
        return self.entry.name

    @property
    def origin(self) -> str:
        """Package and object, for people and for records."""
        return f"{self.package}, {self.entry.value}"

    def load(self) -> Any:
        """Import the module and return the object; this may raise anything."""
        return self.entry.load()


def additions(group: str) -> List[Addition]:
    """Return the entry points of a group.

    A package that Python finds in two places counts once, as the one that it imports.
    """
    found: Dict[Tuple[str, str], Addition] = {}
    for package in metadata.distributions():
        for entry in package.entry_points:
            if entry.group == group and (entry.name, entry.value) not in found:
                about = package.metadata
                found[entry.name, entry.value] = Addition(
                    entry, f"{about['Name']} {package.version}", about["Summary"] or ""
                )
    return list(found.values())
