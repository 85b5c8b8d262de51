"""What the tests of several files share."""

import sys
import tempfile
from pathlib import Path

from foreign_formats_kit import PACKAGE, entries

# The example surveys of gpr20_analysis's tests.
sys.path.append(str(PACKAGE.parent / "gpr20_analysis/test/unit"))

from command_kit import install, refusals  # noqa: F401

# gpr20 finds the package as where its pyproject.toml was installed by pip.
_site = tempfile.TemporaryDirectory()
install(Path(_site.name), entries(), PACKAGE.name)
sys.path.append(_site.name)
