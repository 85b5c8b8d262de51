"""Write the reference of the public interface of gpr20_analysis; started by api_reference.sh."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import pdoc

import gpr20_analysis

PACKAGE = "gpr20_analysis"
WITHOUT_SUBMODULES = f"!{PACKAGE}\\."


def build(folder: Path) -> Path:
    """Write the pages.

    Args:
        folder: Where they are written; made if it does not exist.

    Returns:
        The page of the package.

    Raises:
        Warning: A docstring or an annotation cannot be shown.
    """
    # pdoc looks for the names of a module in it, where each appears when it is first used.
    for name in gpr20_analysis.__all__:
        setattr(gpr20_analysis, name, getattr(gpr20_analysis, name))
    pdoc.render.configure(docformat="google", show_source=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pdoc.pdoc(PACKAGE, WITHOUT_SUBMODULES, output_directory=folder)
    return folder / f"{PACKAGE}.html"


if __name__ == "__main__":
    print(build(Path(sys.argv[1])))
