"""An installed package has the files that browsers get."""

import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
SOURCES = PACKAGE / "src/gpr20_web"


def test_setup_installs_every_file_of_the_pages():
    (listed,) = re.findall(
        r'package_data=\{"gpr20_web": \[(.*)\]\}', (PACKAGE / "setup.py").read_text()
    )
    patterns = re.findall(r'"(.*?)"', listed)
    installed = {one for pattern in patterns for one in SOURCES.glob(pattern) if one.is_file()}
    files = {one for one in (SOURCES / "static").rglob("*") if one.is_file()}
    assert files and installed == files
