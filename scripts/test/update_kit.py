"""Small packages of two versions and their signed sticks, for tests of gpr20-update.

The maintainer scripts of the package and the program are the real ones.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from pathlib import Path
from typing import Dict, Iterable, Mapping, Optional

ROOT = Path(__file__).resolve().parents[2]
SIGNER = "release@gpr20.example"
# A robot without a network may believe that it is earlier.
SIGNED_AT = "20380101T000000"
# Files of a release; enough that a cut hits the middle of them.
FILES_OF_RELEASE, SIZE_BYTES = 40, 4_000
UPDATER = {
    f"deploy/update/{one.relative_to(ROOT / 'deploy/update')}": one.read_bytes()
    for one in (ROOT / "deploy/update").rglob("*.py")
}


def run(*command: object, cwd: Optional[Path] = None, **more: str) -> str:
    """Run a program that must succeed; return what it printed."""
    words = list(map(str, command))
    environment = {**os.environ, **more}
    done = subprocess.run(
        words, cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def release_files(version: str, size_bytes: int = SIZE_BYTES) -> Dict[str, bytes]:
    """Return the files of a release by their path in a slot, the program among them."""
    files = {"release": f"{version}\n".encode(), **UPDATER}
    for number in range(FILES_OF_RELEASE):
        # No two versions have one alike.
        seed = hashlib.sha256(f"{version} {number}".encode()).digest()
        files[f"lib/folder{number % 3}/file{number}"] = seed * (size_bytes // len(seed))
    return files


def make_deb(
    folder: Path,
    name: str,
    version: str,
    files: Mapping[str, bytes],
    conffiles: Iterable[str] = (),
    scripts: Iterable[Path] = (),
    **fields: str,
) -> Path:
    """Make one package.

    Args:
        folder: Where to.
        name: Its name.
        version: Its version.
        files: What it holds, by path without the first slash.
        conffiles: Which of its files are configuration.
        scripts: Its maintainer scripts, each with the ending that says which.
        **fields: Further fields of its description.
    """
    tree = folder / f"tree_{name}"
    (tree / "DEBIAN").mkdir(parents=True)
    fields = {"Package": name, "Version": version, "Architecture": "all", **fields}
    fields = {"Installed-Size": "100", **fields, "Maintainer": SIGNER, "Description": "for a test"}
    lines = [f"{key}: {value}" for key, value in fields.items()]
    (tree / "DEBIAN/control").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tree / "DEBIAN/conffiles").write_text("".join(f"/{one}\n" for one in conffiles))
    for path, data in files.items():
        file = tree / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        file.chmod(0o755 if "bin/" in path else 0o644)
    for source in scripts:
        script = tree / "DEBIAN" / source.suffix[1:]
        script.write_text(source.read_text("utf-8").replace("#DEBHELPER#", ""), encoding="utf-8")
        script.chmod(0o755)
    deb = folder / f"{name}_{version}_all.deb"
    run("dpkg-deb", "--root-owner-group", "-Znone", "--build", tree, deb)
    shutil.rmtree(tree)
    return deb


def release_key(place: Path) -> str:
    """Make a key that signs releases; return the folder of gpg."""
    (place / "gpg").mkdir(mode=0o700, parents=True)
    home = str(place / "gpg")
    gpg(home, "--passphrase", "", "--quick-generate-key", SIGNER, "ed25519", "sign", "never")
    return home


def gpg(home: str, *words: object) -> str:
    """Run gpg in its folder, at a time that is not that of the robot."""
    try:
        return run("gpg", "--batch", "--faked-system-time", SIGNED_AT, *words, GNUPGHOME=home)
    finally:
        run("gpgconf", "--kill", "all", GNUPGHOME=home)


def sign(stick: Path, home: str) -> None:
    """Write the index of a stick, and its signature, as scripts/stick.sh does."""
    (stick / "InRelease").unlink(missing_ok=True)
    index = run("dpkg-scanpackages", "--multiversion", ".", cwd=stick)
    (stick / "Packages").write_text(index, encoding="utf-8")
    digest = hashlib.sha256(index.encode()).hexdigest()
    text = f"Date: Fri, 01 Jan 2038 00:00:00 UTC\nSHA256:\n {digest} {len(index)} Packages\n"
    (stick.parent / "Release").write_text(text, encoding="utf-8")
    gpg(home, "--clearsign", "--output", stick / "InRelease", stick.parent / "Release")
    (stick / "release_key.asc").write_text(gpg(home, "--armor", "--export"), encoding="utf-8")
    shutil.copy(ROOT / "deploy/install.sh", stick / "install.sh")


def make_stick(
    sticks: Path,
    version: str,
    home: str,
    more: Optional[Mapping[str, bytes]] = None,
    size_bytes: int = SIZE_BYTES,
) -> Path:
    """Make a stick with one version; return its folder.

    Args:
        sticks: The folder in which it is made.
        version: Its version.
        home: Folder of gpg with the key that signs it.
        more: Further files of the package, by path.
        size_bytes: Of each file of the release.
    """
    stick = sticks / version
    stick.mkdir(parents=True)
    release = release_files(version, size_bytes)
    program = ROOT / "deploy/root/usr/sbin/gpr20-update"
    files = {
        **{f"opt/gpr20/unpacked/{name}": one for name, one in release.items()},
        "etc/gpr20/robot.conf": f"# {version}\nGPR20_LAUNCH_ARGUMENTS=\n".encode(),
        "lib/systemd/system/gpr20.service": f"# {version}\n".encode(),
        "usr/sbin/gpr20-update": program.read_bytes(),
        **(more or {}),
    }
    scripts = sorted((ROOT / "debian").glob("gpr20.p*"))
    needs = {"Depends": f"other-library (>= {version})", "Recommends": "not-on-the-stick"}
    make_deb(stick, "gpr20", version, files, ["etc/gpr20/robot.conf"], scripts, **needs)
    make_deb(stick, "other-library", version, {"usr/lib/other": version.encode()})
    sign(stick, home)
    return stick


def data_of(root: Path) -> Dict[str, str]:
    """Return the checksum of every file of the configuration and of the surveys."""
    return {
        str(one.relative_to(root)): hashlib.sha256(one.read_bytes()).hexdigest()
        for folder in ("etc/gpr20", "var/lib/gpr20")
        for one in sorted((root / folder).rglob("*"))
        # What a new version would like to have; it is not used.
        if one.is_file() and one.suffix != ".dpkg-dist"
    }


def slot_problems(root: Path, size_bytes: int = SIZE_BYTES) -> str:
    """Return what is wrong with the release that `current` names; empty: it is whole."""
    current = root / "opt/gpr20/current"
    slot = root / "opt/gpr20" / (os.readlink(current) if current.is_symlink() else "missing")
    try:
        version = (slot / "release").read_text("utf-8").strip()
    except OSError as error:
        return f"no release: {error}"
    found = {
        str(one.relative_to(slot)): one.read_bytes() for one in slot.rglob("*") if one.is_file()
    }
    return "" if found == release_files(version, size_bytes) else f"{slot} is not {version}"
