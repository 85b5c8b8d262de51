"""The reference of the public interface is built without warnings, and leaves nothing out."""

from __future__ import annotations

import api_reference
import pytest

import gpr20_analysis

PUBLIC = {name: getattr(gpr20_analysis, name) for name in gpr20_analysis.__all__}


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    folder = tmp_path_factory.mktemp("reference")
    return api_reference.build(folder).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_in_the_reference(page, name):
    assert f'id="{name}"' in page


def test_no_part_of_the_package_below_is_in_it(page):
    assert "gpr20_analysis.commands" not in page
