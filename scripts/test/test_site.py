"""The site of the documentation: complete, without dead links, and it needs no network."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from html import escape

import pytest
from user_shell import ROOT

sys.path.insert(0, str(ROOT / "tools/site"))

from messages_page import all_faults
from messages_page import page as messages_page
from pictures.architecture import pictures
from pictures.graph import nodes_of
from site_markdown import changelog_markdown, heading_anchor, indent_lists
from wings_kit import NEEDS_ALL

# The pages name and link every package.
pytestmark = NEEDS_ALL

LIMIT_S = 300.0
DOCS = ROOT / "docs"


def build(config, folder):
    """Build a site as scripts/site.sh does; return how it ended."""
    paths = [str(ROOT / "tools/pages"), str(ROOT / "tools/site"), os.environ.get("PYTHONPATH", "")]
    return subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", config, "-d", folder],
        env={**os.environ, "PYTHONPATH": ":".join(paths), "NO_MKDOCS_2_WARNING": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    ended = build(ROOT / "mkdocs.yml", folder)
    assert ended.returncode == 0, ended.stdout
    return folder


@pytest.mark.release
def test_every_page_of_the_repository_is_on_the_site(site):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS).with_suffix(".html")).exists()
    for readme in ROOT.glob("catkin_ws/src/gpr20_*/README.md"):
        assert (site / "packages" / f"{readme.parent.name}.html").exists()
    assert (site / "project/changelog.html").exists()


@pytest.mark.release
def test_each_page_is_once_in_the_menu_and_linked_from_the_start(site):
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    start = (DOCS / "index.md").read_text(encoding="utf-8")
    for page in DOCS.rglob("*.md"):
        name = page.relative_to(DOCS).as_posix()
        assert text.count(f": {name}\n") == 1, name
        assert name == "index.md" or f"]({name}" in start, name


@pytest.mark.release
@pytest.mark.parametrize(
    ("page", "picture"),
    [("architecture", "states"), ("reference/ros_graph", "graph"), ("ros", "frames")],
)
def test_each_page_shows_its_own_diagrams(site, page, picture):
    shown = re.findall(
        r'src="[./]*images/(\w+)\.svg"', (site / f"{page}.html").read_text(encoding="utf-8")
    )
    assert shown.count(picture) == 1
    assert page == "architecture" or "states" not in shown


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
    assert 'id="load_survey"' in (site / "api/gpr20_analysis.html").read_text(encoding="utf-8")
    assert 'href="../api/gpr20_analysis.html"' in (site / "reference/api.html").read_text(
        encoding="utf-8"
    )


@pytest.mark.release
@pytest.mark.parametrize("link", ["nothing.md", "operate.md#nothing"])
def test_a_dead_link_fails_the_build(tmp_path, link):
    shutil.copytree(DOCS, tmp_path / "docs")
    with (tmp_path / "docs/maintain.md").open("a") as page:
        page.write(f"\n[dead]({link})\n")
    (tmp_path / "tools").symlink_to(ROOT / "tools")
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    ended = build(tmp_path / "mkdocs.yml", tmp_path / "site")
    assert ended.returncode != 0
    assert link in ended.stdout


@pytest.mark.parametrize(
    ("github", "mkdocs"),
    [
        ("- a\n  b\n", "- a\n    b\n"),
        ("1. a\n\n   ```\n     code\n   ```\n", "1. a\n\n    ```\n      code\n    ```\n"),
        ("text\n- a\n  - b\n    c\n", "text\n\n- a\n    - b\n        c\n"),
        ("- a\n\ntext\n", "- a\n\ntext\n"),
        ("- a\n\n  | b |\n", "- a\n\n    | b |\n"),
        ("- a\n# b\n", "- a\n\n# b\n"),
        ("```\n- a\n  b\n```\n", "```\n- a\n  b\n```\n"),
    ],
)
def test_lists_are_those_of_github(github, mkdocs):
    assert indent_lists(github) == mkdocs


def test_the_changelog_of_ros_is_a_page_with_a_heading_for_each_version():
    ros = "^^^^\nAll\n^^^^\n\n0.1.0 (2026-11-22)\n------------------\n\n**New**\n\n- ``a``\n"
    assert changelog_markdown(ros) == "# All\n\n## 0.1.0 (2026-11-22)\n\n**New**\n\n- `a`\n"


def test_the_pictures_of_the_architecture_are_up_to_date():
    for name, text in pictures().items():
        picture = (DOCS / "images" / name).read_text(encoding="utf-8")
        assert picture == text, "run scripts/pictures.sh architecture"


def test_the_picture_of_the_graph_names_every_node_and_interface():
    picture = (DOCS / "images/graph.svg").read_text(encoding="utf-8")
    nodes = nodes_of((DOCS / "reference/ros_graph.md").read_text(encoding="utf-8"))
    assert {"main_control", "vna_processing", "replay"} <= set(nodes)
    for node, interfaces in nodes.items():
        assert f"{escape(node.split(', ')[0])}<" in picture
        assert all(f">{escape(interface)}<" in picture for interface, _kind in interfaces)


def test_the_page_of_the_faults_is_up_to_date_and_names_every_code_and_remedy():
    text = messages_page()
    assert (DOCS / "reference/messages.md").read_text(encoding="utf-8") == text, (
        "run scripts/translations.sh"
    )
    words = " ".join(text.replace("<br>", "").replace("\\", "").split())
    for fault in all_faults():
        assert f"- `{fault.code}`" in words
        assert fault.remedy is None or fault.remedy.template in words
