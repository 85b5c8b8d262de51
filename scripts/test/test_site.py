"""The site of the documentation is built without a dead link, and needs no network."""

from __future__ import annotations

import re

import pytest
from user_shell import ROOT, printed_by


@pytest.mark.release
def test_the_site_loads_nothing_from_a_network(tmp_path):
    printed_by(ROOT / "scripts/site.sh", tmp_path / "site")
    loads = r"""<(?:script|img|iframe|source)[^>]*\ssrc="(//|https?:)[^>]*>"""
    styles = r"""<link[^>]*rel="(?:stylesheet|preload|preconnect|icon)"[^>]*href="https?:[^>]*>"""
    for page in (tmp_path / "site").rglob("*.html"):
        found = re.search(f'{loads}|{styles}|class="mermaid', page.read_text(encoding="utf-8"))
        assert not found, page
