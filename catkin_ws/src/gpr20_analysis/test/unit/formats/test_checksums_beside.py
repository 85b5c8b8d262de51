"""The checksums beside an export are those of sha256sum."""

from __future__ import annotations

import subprocess

import pytest
from random_surveys import random_survey

from gpr20_analysis.formats.conversion import export_survey


@pytest.mark.parametrize(
    ("form", "name"),
    [
        ("touchstone", "out"),
        ("csv", "out.csv"),
        ("segy", "out.sgy"),
    ],
)
def test_sha256sum_checks_an_export(tmp_path, form, name):
    export_survey(random_survey(1, one_polarization=True), tmp_path / name, form)
    (sums,) = tmp_path.glob("*.sha256")
    command = ["sha256sum", "--strict", "--check", sums.name]
    subprocess.run(command, cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    exported = sums.with_suffix("")
    victim = exported if exported.is_file() else sorted(exported.iterdir())[0]
    victim.write_bytes(victim.read_bytes() + b"0")
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True)
    assert done.returncode == 1 and victim.name in done.stdout.decode()
