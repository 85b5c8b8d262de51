"""The site of the documentation needs no network, and has what no page of Markdown has."""

from __future__ import annotations

import html
import re
import sys

import pytest
from user_shell import ROOT, printed_by

sys.path.insert(0, str(ROOT / "tools/site"))

from site_hooks import all_faults, heading_anchor

import gpr20_analysis

pytestmark = pytest.mark.release


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    printed_by(ROOT / "scripts/site.sh", folder)
    return folder


def text_of(page):
    return page.read_text(encoding="utf-8")


def test_nothing_is_loaded_from_a_network(site):
    loads = r"""<(?:script|img|iframe|source)[^>]*\ssrc="(//|https?:)[^>]*>"""
    styles = r"""<link[^>]*rel="(?:stylesheet|preload|preconnect|icon)"[^>]*href="https?:[^>]*>"""
    for page in site.rglob("*.html"):
        assert not re.search(f'{loads}|{styles}|class="mermaid', text_of(page)), page


def test_interfaces_api_and_every_message_are_on_it(site):
    interfaces = text_of(site / "catkin_ws/src/gpr20_msgs/index.html")
    for path in ROOT.glob("catkin_ws/src/gpr20_msgs/*/*.*"):
        if path.suffix[1:] == path.parent.name:
            assert f'id="{heading_anchor(path.stem)}"' in interfaces
    api = text_of(site / "api/gpr20_analysis.html")
    assert [one for one in gpr20_analysis.__all__ if f'id="{one}"' not in api] == []
    assert 'href="../../api/gpr20_analysis.html"' in text_of(site / "docs/reference/api.html")
    messages = text_of(site / "docs/reference/messages.html")
    words = " ".join(html.unescape(re.sub("<[^>]*>", "", messages)).split())
    for fault in all_faults():
        assert f"<code>{fault.code}</code>" in messages
        assert fault.remedy is None or " ".join(fault.remedy.template.split()) in words
