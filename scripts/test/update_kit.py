"""Small packages of two versions and their signed bundles, for tests of gpr20-update.

The maintainer scripts of gpr20-software and the program are the real ones.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import zipapp
from pathlib import Path
from typing import Dict, Iterable, Mapping, Optional

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("gpr20-software", "gpr20-common", "gpr20-robot")
SIGNER = "release@gpr20.example"
# Files of a release; enough that a cut hits the middle of them.
FILES_OF_RELEASE, SIZE_BYTES = 40, 4_000


def run(*command: object, cwd: Optional[Path] = None) -> str:
    """Run a program that must succeed; return what it printed."""
    words = list(map(str, command))
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def make_program(target: Path, main: Optional[str] = None) -> None:
    """Make the program as debian/rules does; with another __main__.py for a test."""
    source = target.with_name(f"{target.name}_source")
    shutil.copytree(ROOT / "deploy/update", source, ignore=shutil.ignore_patterns("__pycache__"))
    if main is not None:
        (source / "__main__.py").write_text(main, encoding="utf-8")
    entry = None if main else "gpr20_update.high.command:main"
    zipapp.create_archive(source, target, "/usr/bin/python3 -I", entry)
    shutil.rmtree(source)


def release_files(version: str, size_bytes: int = SIZE_BYTES) -> Dict[str, bytes]:
    """Return the files of a release by their path in a slot; no two versions have one alike."""
    files = {"release": f"{version}\n".encode()}
    for number in range(FILES_OF_RELEASE):
        seed = hashlib.sha256(f"{version} {number}".encode()).digest()
        files[f"lib/folder{number % 3}/file{number}"] = seed * (size_bytes // len(seed))
    return files


def make_deb(
    folder: Path,
    name: str,
    version: str,
    files: Mapping[str, bytes],
    depends: str = "",
    conffiles: Iterable[str] = (),
    scripts: bool = False,
) -> Path:
    """Make one package.

    Args:
        folder: Where to.
        name: Its name.
        version: Its version.
        files: What it holds, by path without the first slash.
        depends: What it needs.
        conffiles: Which of its files are configuration.
        scripts: Whether it has the maintainer scripts of debian/.
    """
    tree = folder / f"tree_{name}"
    (tree / "DEBIAN").mkdir(parents=True)
    fields = {"Package": name, "Version": version, "Architecture": "all", "Depends": depends}
    fields.update(Maintainer=SIGNER, Description="for a test", **{"Installed-Size": "100"})
    lines = [f"{key}: {value}" for key, value in fields.items() if value]
    (tree / "DEBIAN/control").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tree / "DEBIAN/conffiles").write_text("".join(f"/{one}\n" for one in conffiles))
    for path, data in files.items():
        file = tree / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        file.chmod(0o755 if "bin/" in path else 0o644)
    for source in (ROOT / "debian").glob(f"{name}.p*") if scripts else ():
        script = tree / "DEBIAN" / source.suffix[1:]
        script.write_text(source.read_text("utf-8").replace("#DEBHELPER#", ""), encoding="utf-8")
        script.chmod(0o755)
    deb = folder / f"{name}_{version}_all.deb"
    run("dpkg-deb", "--root-owner-group", "-Znone", "--build", tree, deb)
    shutil.rmtree(tree)
    return deb


def make_key(folder: Path, name: str = "key") -> Path:
    """Make a key that signs releases; return the private file."""
    run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / name)
    return folder / name


def signers_line(key: Path) -> str:
    """Return the line that accepts releases of a key."""
    kind, blob = key.with_name(f"{key.name}.pub").read_text("utf-8").split()[:2]
    return f'{SIGNER} namespaces="gpr20-release" {kind} {blob}\n'


def sign(
    bundle: Path, key: Path, namespace: str = "gpr20-release", index: Optional[str] = None
) -> None:
    """Write index, checksums and signature of a bundle; the index may be a wrong one."""
    for name in ("Packages", "SHA256SUMS", "SHA256SUMS.sig"):
        (bundle / name).unlink(missing_ok=True)
    index = index or run("dpkg-scanpackages", "--multiversion", ".", cwd=bundle)
    (bundle / "Packages").write_text(index, encoding="utf-8")
    names = sorted(one.name for one in bundle.iterdir())
    sums = {one: hashlib.sha256((bundle / one).read_bytes()).hexdigest() for one in names}
    (bundle / "SHA256SUMS").write_text("".join(f"{sums[one]}  {one}\n" for one in names))
    run("ssh-keygen", "-q", "-Y", "sign", "-f", key, "-n", namespace, bundle / "SHA256SUMS")


def make_bundle(
    stick: Path,
    version: str,
    key: Path,
    program: Path,
    more: Optional[Mapping[str, bytes]] = None,
    size_bytes: int = SIZE_BYTES,
) -> Path:
    """Make a bundle of one version; return its folder.

    Args:
        stick: The folder in which it is made.
        version: Its version.
        key: Who signs it.
        program: The program gpr20-update of this version.
        more: Further files of gpr20-common, by path.
        size_bytes: Of each file of the release.
    """
    bundle = stick / f"gpr20-{version}"
    bundle.mkdir(parents=True)
    files = release_files(version, size_bytes)
    release = {f"opt/gpr20/unpacked/{name}": one for name, one in files.items()}
    make_deb(bundle, "gpr20-software", version, release, scripts=True)
    common = {
        "etc/gpr20/environment": f"# {version}\nGPR20_LAUNCH_ARGUMENTS=\n".encode(),
        "etc/gpr20/release_signers": signers_line(key).encode(),
        "usr/sbin/gpr20-update": program.read_bytes(),
        **(more or {}),
    }
    needs = f"gpr20-software (>= {version}), other-library (>= {version})"
    conffiles = [name for name in common if name.startswith("etc/")]
    make_deb(bundle, "gpr20-common", version, common, needs, conffiles)
    unit = {"lib/systemd/system/gpr20-robot.service": f"# {version}\n".encode()}
    make_deb(bundle, "gpr20-robot", version, unit, f"gpr20-common (= {version})")
    make_deb(bundle, "other-library", version, {"usr/lib/other": version.encode()})
    sign(bundle, key)
    return bundle


def slot_problems(root: Path, size_bytes: int = SIZE_BYTES) -> str:
    """Return what is wrong with the release that `current` names; empty: it is whole."""
    current = root / "opt/gpr20/current"
    slot = root / "opt/gpr20" / (current.readlink() if current.is_symlink() else "missing")
    try:
        version = (slot / "release").read_text("utf-8").strip()
    except OSError as error:
        return f"no release: {error}"
    found = {
        str(one.relative_to(slot)): one.read_bytes() for one in slot.rglob("*") if one.is_file()
    }
    return "" if found == release_files(version, size_bytes) else f"{slot} is not {version}"
