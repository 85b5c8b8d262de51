"""Keys that sign surveys, and what accepts them."""

from pathlib import Path

from gpr20_survey.files import ssh_keygen
from gpr20_survey.folder.signature import NAMESPACE


def make_key(path: Path, passphrase: str = "") -> None:
    """Make a key of the kind that `robot_config key` makes."""
    made = ssh_keygen.ask(("-q", "-t", "ed25519", "-N", passphrase, "-C", "robot", "-f", path))
    assert made.yes, made.complaint


def fingerprint(path: Path) -> str:
    """Return the fingerprint of a key."""
    return ssh_keygen.use_key(path, ("-l",)).split()[1]


def signers_line(path: Path, signer: str = "robot") -> str:
    """Return the line of a signers file that accepts a key."""
    kind, key = ssh_keygen.use_key(path, ("-y", "-P", "")).split()[:2]
    return f'{signer} namespaces="{NAMESPACE}" {kind} {key}\n'
