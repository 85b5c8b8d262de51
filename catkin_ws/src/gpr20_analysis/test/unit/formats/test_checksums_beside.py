"""The checksums beside an export are those of sha256sum."""

from __future__ import annotations

import pytest
from checksum_kit import check_with_sha256sum
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
    check_with_sha256sum(tmp_path)
