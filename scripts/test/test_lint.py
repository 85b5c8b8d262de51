"""The sources pass the lint."""

import os
import subprocess

from user_shell import ROOT

LIMIT_S = 600.0


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
