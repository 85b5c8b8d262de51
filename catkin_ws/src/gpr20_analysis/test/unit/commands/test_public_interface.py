"""The public interface is what docs/reference/api.md shows, and importing it costs nothing."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path

import gpr20_analysis

ROOT = Path(__file__).resolve().parents[6]
DOCUMENT = ROOT / "docs/reference/api.md"
HEAVY = ("numpy", "xarray", "dask", "scipy", "matplotlib", "h5py", "rosbags", "rospy")


def example() -> str:
    return re.search(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)[1]


def test_the_example_of_the_document_runs(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / re.search(r'"~/(.*)"', example())[1]
    importlib.import_module("recorded_survey_kit").make(folder, 3, 4, 101)
    names = {}
    exec(example(), names)  # noqa: S102
    assert str(names["verdict"]).startswith("complete and intact")
    assert names["survey"].s21.shape == (2, 4, 3, 101)
    assert names["image"].image.dims == ("polarization", "depth", "y", "x")
    assert gpr20_analysis.load_survey("survey.nc").equals(names["survey"])


def test_every_public_name_is_there_documented_and_told():
    printed = DOCUMENT.read_text(encoding="utf-8")
    for name in gpr20_analysis.__all__:
        assert getattr(gpr20_analysis, name).__doc__
        assert f"`{name}`" in printed


def test_importing_and_the_list_of_commands_load_no_library():
    program = (
        "import sys, gpr20_analysis; from gpr20_analysis.commands.main import main; "
        f"main(['--help']); print('LOADED', [one for one in {HEAVY} if one in sys.modules])"
    )
    printed = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, check=True)
    assert printed.stdout.decode().endswith("LOADED []\n")
