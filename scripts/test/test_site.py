"""The site of the documentation: complete, without dead links, and it needs no network."""

from __future__ import annotations

import html
import os
import re
import sys

import pytest
from user_shell import ROOT, printed_by

sys.path.insert(0, str(ROOT / "tools/site"))

from messages_page import all_faults
from pictures.architecture import pictures
from site_markdown import heading_anchor
from wings_kit import NEEDS_ALL

import gpr20_analysis

# The pages name and link every package.
pytestmark = NEEDS_ALL

DOCS = ROOT / "docs"


def build(config, folder, status=0):
    """Build a site as scripts/site.sh does; return what that said."""
    own = [ROOT / "tools/pages", ROOT / "tools/site", *ROOT.glob("catkin_ws/src/*/src")]
    paths = [*map(str, own), os.environ.get("PYTHONPATH", "")]
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", config, "-d", folder]
    more = {"PYTHONPATH": ":".join(paths), "NO_MKDOCS_2_WARNING": "1"}
    return printed_by(*command, status=status, **more)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    build(ROOT / "mkdocs.yml", folder)
    return folder


@pytest.mark.release
def test_every_page_of_the_repository_is_on_the_site(site):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS).with_suffix(".html")).exists()
    for readme in ROOT.glob("catkin_ws/src/gpr20_*/README.md"):
        assert (site / "packages" / f"{readme.parent.name}.html").exists()
    assert (site / "project/changelog.html").exists()


@pytest.mark.release
def test_nothing_is_loaded_from_a_network(site):
    loads = r"""<(?:script|img|iframe|source)[^>]*\ssrc="(//|https?:)[^>]*>"""
    styles = r"""<link[^>]*rel="(?:stylesheet|preload|preconnect|icon)"[^>]*href="https?:[^>]*>"""
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(f"{loads}|{styles}", text), page


@pytest.mark.release
def test_the_ros_interfaces_and_the_python_api_are_on_it(site):
    interfaces = (site / "packages/gpr20_msgs.html").read_text(encoding="utf-8")
    for folder in ("msg", "srv", "action"):
        for path in (ROOT / "catkin_ws/src/gpr20_msgs" / folder).iterdir():
            assert f'id="{heading_anchor(path.stem)}"' in interfaces
    api = (site / "api/gpr20_analysis.html").read_text(encoding="utf-8")
    assert [one for one in gpr20_analysis.__all__ if f'id="{one}"' not in api] == []
    assert "gpr20_analysis.commands" not in api
    assert 'href="../api/gpr20_analysis.html"' in (site / "reference/api.html").read_text(
        encoding="utf-8"
    )


def test_the_pictures_of_the_architecture_are_up_to_date():
    for name, text in pictures().items():
        picture = (DOCS / "images" / name).read_text(encoding="utf-8")
        assert picture == text, "run scripts/pictures.sh architecture"


@pytest.mark.release
def test_the_page_of_the_messages_names_every_code_and_remedy(site):
    page = (site / "reference/messages.html").read_text(encoding="utf-8")
    words = " ".join(html.unescape(re.sub("<[^>]*>", "", page)).split())
    for fault in all_faults():
        assert f"<code>{fault.code}</code>" in page
        assert fault.remedy is None or " ".join(fault.remedy.template.split()) in words
