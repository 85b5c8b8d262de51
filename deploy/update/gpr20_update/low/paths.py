"""Where everything is that an update reads or writes."""

from __future__ import annotations

from pathlib import Path


class Paths:
    """The files of one computer.

    Args:
        root: Its / ; a folder in the tests.
    """

    def __init__(self, root: Path = Path("/")) -> None:
        self.root = root
        self.state = root / "var/lib/gpr20-update"
        self.kept = self.state / "packages"
        """The bundles that are kept, each in a folder named by its version."""
        self.backups = self.state / "backups"
        self.journal = self.state / "journal.json"
        """gpr20-update.service looks for it too."""
        self.program = self.state / "gpr20-update"
        """The copy of this program that finishes what it has begun."""
        self.settings = root / "etc/gpr20/environment"
        self.signers = root / "etc/gpr20/release_signers"
        self.slots = root / "opt/gpr20/slots"
        self.current = root / "opt/gpr20/current"
        self.processes = root / "proc"
        self.dpkg = root / "var/lib/dpkg"
