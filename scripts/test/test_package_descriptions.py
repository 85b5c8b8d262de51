"""All packages have one version, maintainer, licence and addresses, and pinned requirements."""

from __future__ import annotations

import re

import yaml
from user_shell import ROOT

PACKAGES = [*ROOT.glob("catkin_ws/src/*/package.xml")]
(VERSION,) = re.findall(
    r'^current_version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE
)
PINNED = {
    "3.8": ["nodes", "test", "system"],
    "3.11": ["nodes", "test", "lint", "docs", "robot"],
    "3.13": ["nodes", "test", "system"],
}


def test_every_package_has_the_people_licence_and_addresses_of_the_project():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    wanted = [*citation["contact"][0].values(), citation["license"]]
    wanted += [citation[key] for key in ("url", "repository-code") if key in citation]
    for path in [*PACKAGES, *ROOT.glob("catkin_ws/src/*/pyproject.toml")]:
        text = path.read_text(encoding="utf-8")
        assert [one for one in wanted if one not in text] == [], path


def test_every_version_is_that_of_all():
    texts = [path.read_text() for path in [*PACKAGES, ROOT / "CITATION.cff"]]
    found = [re.findall(r"(?:<version>|^version: )([\w.]+)", one, re.MULTILINE) for one in texts]
    texts = [path.read_text() for path in ROOT.glob("catkin_ws/src/*/src/*/__init__.py")]
    found += filter(None, (re.findall(r'^__version__ = "(.+)"$', one, re.M) for one in texts))
    assert len(found) > 10
    assert found == [[VERSION]] * len(found), "change it by scripts/release.sh, never by hand"


def names(path):
    """Return the packages of a requirements file, as pip compares them."""
    found = re.findall(r"^([A-Za-z][\w.-]*)(?!.*python_version)", path.read_text(), re.MULTILINE)
    return {re.sub(r"[-_.]+", "-", one).lower() for one in found}


def test_every_listed_requirement_is_pinned():
    for python, lists in PINNED.items():
        pinned = names(ROOT / f"requirements/python{python}.txt")
        missing = {one for file in lists for one in names(ROOT / f"requirements/{file}.in")}
        assert missing <= pinned, "run scripts/requirements.sh"
