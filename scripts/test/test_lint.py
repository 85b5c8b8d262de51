"""The sources pass the lint."""

import os
import subprocess

from user_shell import ROOT
from wings_kit import NEEDS_ALL

LIMIT_S = 600.0


@NEEDS_ALL
def test_the_lint_finds_nothing():
    ended = subprocess.run(
        [str(ROOT / "scripts/lint.sh")],
        env=os.environ,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )
    assert ended.returncode == 0, ended.stdout
