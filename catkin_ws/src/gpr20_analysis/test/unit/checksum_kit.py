"""Checks the checksums beside an export with the program that people use."""

from __future__ import annotations

import subprocess
from pathlib import Path


def check_with_sha256sum(folder: Path) -> None:
    """Assert that `sha256sum` accepts the only export in a folder, and finds a byte too much."""
    (sums,) = folder.glob("*.sha256")
    command = ["sha256sum", "--strict", "--check", sums.name]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    exported = sums.with_suffix("")
    victim = exported if exported.is_file() else sorted(exported.iterdir())[0]
    victim.write_bytes(victim.read_bytes() + b"0")
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True)
    assert done.returncode == 1 and victim.name in done.stdout.decode()
