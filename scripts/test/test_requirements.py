"""The pinned requirements of each Python belong to the lists that are written by hand."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "requirements"
LISTS = {
    "3.8": ["nodes", "test", "system"],
    "3.11": ["nodes", "test", "lint", "docs", "robot"],
    "3.13": ["nodes", "test", "system"],
}


def names(path):
    """Return the packages of a requirements file, as pip compares them."""
    found = re.findall(r"^([A-Za-z][\w.-]*)(?!.*python_version)", path.read_text(), re.MULTILINE)
    return {re.sub(r"[-_.]+", "-", one).lower() for one in found}


@pytest.mark.parametrize("python", LISTS)
def test_every_listed_package_is_pinned(python):
    pinned = names(FOLDER / f"python{python}.txt")
    for listed in LISTS[python]:
        missing = names(FOLDER / f"{listed}.in") - pinned
        assert not missing, f"run scripts/requirements.sh: no version of {sorted(missing)}"
