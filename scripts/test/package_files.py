"""The Debian packages, built around a small tree in place of the workspace, and their files."""

from __future__ import annotations

import re
import shutil
import subprocess

from user_shell import ROOT, printed_by

VERSION = "1.2.3"
CHANGELOG = f"""gpr20 ({VERSION}) stable; urgency=medium

  * A change.

 -- Someone <someone@robot.example>  Fri, 27 Nov 2026 12:00:00 +0000
"""
# What debian/install makes, without building.
INSTALL = """#!/bin/sh
mkdir -p "$GPR20_PACKAGE/deploy"
cp deploy/gpr20-run "$GPR20_PACKAGE/deploy"
dpkg-parsechangelog -S Version >"$GPR20_PACKAGE/release"
"""


class Packages:
    """What was built, as .deb files in a folder."""

    def __init__(self, folder):
        self.folder = folder

    def file(self, name):
        (found,) = self.folder.glob(f"{name}_{VERSION}_*.deb")
        return found

    def extract(self, target, *names):
        """Write the files of packages below a folder, without running their scripts."""
        # As on an installed system.
        for name in ("bin", "lib", "sbin"):
            (target / "usr" / name).mkdir(parents=True, exist_ok=True)
            (target / name).symlink_to(f"usr/{name}")
        for name in names:
            # Not dpkg-deb --extract, which would replace the links by folders.
            files = subprocess.Popen(
                ["dpkg-deb", "--fsys-tarfile", str(self.file(name))], stdout=subprocess.PIPE
            )
            unpack = ["tar", "--extract", "--keep-directory-symlink", "--directory", str(target)]
            subprocess.run(unpack, stdin=files.stdout, check=True)
            assert files.wait() == 0

    def field(self, name, field):
        return printed_by("dpkg-deb", "--field", self.file(name), field).strip()

    def control(self, name, part):
        """Return a control file of a package, such as conffiles."""
        return printed_by("dpkg-deb", "--info", self.file(name), part)


def build(folder):
    """Build the packages of this checkout in a folder."""
    sources = folder / "gpr20"
    for name in ("debian", "deploy"):
        shutil.copytree(ROOT / name, sources / name)
    (sources / "docs").mkdir()
    shutil.copy(ROOT / "docs/install.md", sources / "docs")
    (sources / "debian/changelog").write_text(CHANGELOG)
    (sources / "debian/install").write_text(INSTALL)
    options = ["--build=binary", "--no-sign", "--no-check-builddeps"]
    printed_by("dpkg-buildpackage", *options, folder=sources)
    return Packages(folder)


def unit_values(name, key):
    """Return the values of a key of a unit of debian/, with what services share, in their order."""
    (file,) = (ROOT / "debian").glob(f"*{name}.service")
    text = file.read_text("utf-8")
    if name in ("gpr20-robot", "gpr20-server"):
        text += (ROOT / "deploy/service.conf").read_text("utf-8")
    return re.findall(rf"^{key}=(.*)$", text.replace("\\\n", " "), re.MULTILINE)
