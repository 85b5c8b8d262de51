"""What installed packages add to gpr20 by entry points; finding it imports nothing of theirs."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import metadata
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple, Type

from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_common.message import Fault, Message


class Addition(NamedTuple):
    """An entry point of an installed package."""

    entry: metadata.EntryPoint
    package: str
    """The package's name and version."""
    summary: str
    """The package's summary."""

    @property
    def name(self) -> str:
        """Its name."""
        return self.entry.name

    @property
    def origin(self) -> str:
        """Package and object, for people and for records."""
        return f"{self.package}, {self.entry.value}"


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


@dataclass(frozen=True)
class ExtensionPoint:
    """A kind of thing that installed packages can add; nothing of theirs replaces what is there.

    Attributes:
        group: Group of the entry points.
        what: One of its things, such as "the command".
        fault: Fault of an addition that cannot be used.
        own: Those of this package by name.
        wings: Names and packages of those that this project has in packages that are installed
            only where they are wanted.
        kind: Class of what is added; None: anything.
        error: Class of the errors about what is added.
    """

    group: str
    what: Message
    fault: Fault
    own: Mapping[str, Any] = field(default_factory=dict)
    wings: Mapping[str, str] = field(default_factory=dict)
    kind: Optional[type] = None
    error: Type[AnalysisError] = AnalysisError

    def added(self) -> List[str]:
        """Return the names of what installed packages add."""
        names = {one.name for one in additions(self.group)}
        return sorted(names - self.own.keys())

    def names(self) -> List[str]:
        """Return all names, also those of wings that are not installed."""
        return [*self.own, *sorted({*self.added(), *self.wings})]

    def find(self, name: str) -> Any:
        """Return what has a name.

        Raises:
            MissingLibraryError: Its package is not installed.
            AnalysisError: There is none, or its package cannot be used.
        """
        return self.own[name] if name in self.own else self.load(self.addition(name))

    def addition(self, name: str) -> Addition:
        """Return the one addition of a name; see `find`."""
        found = [one for one in additions(self.group) if one.name == name]
        if not found and name in self.wings:
            raise MissingLibraryError(
                Message(
                    "{what} '{name}' is of the package {package}, which is not installed; in a "
                    "clone of the project, install it with: pip install 'catkin_ws/src/{package}'",
                    what=self.what,
                    name=name,
                    package=self.wings[name],
                )
            )
        if not found:
            raise self.error(
                Message(
                    "{what} '{name}' does not exist; there are: {names}",
                    what=self.what,
                    name=name,
                    names=", ".join(self.names()),
                )
            )
        if len(found) > 1:
            origins = "; ".join(one.origin for one in found)
            reason = Message("several packages have it: {origins}; remove one", origins=origins)
            raise self._refusal(name, reason)
        return found[0]

    def load(self, addition: Addition) -> Any:
        """Return what an addition is; see `find`."""
        try:
            loaded = addition.entry.load()
        except Exception as error:  # the package is not ours: it may raise anything
            reason = Message(
                "{origin} cannot be loaded; correct or remove that package: {reason}",
                origin=addition.origin,
                reason=f"{type(error).__name__}: {error}",
            )
            raise self._refusal(addition.name, reason) from error
        if self.kind is not None and not isinstance(loaded, self.kind):
            reason = Message(
                "{origin} is a {type}; it must be a {expected}",
                origin=addition.origin,
                type=type(loaded).__name__,
                expected=f"{self.kind.__module__}.{self.kind.__name__}",
            )
            raise self._refusal(addition.name, reason)
        return loaded

    def _refusal(self, name: str, reason: Message) -> AnalysisError:
        message = Message("{what} '{name}': {reason}", what=self.what, name=name, reason=reason)
        return self.error(message, fault=self.fault)
