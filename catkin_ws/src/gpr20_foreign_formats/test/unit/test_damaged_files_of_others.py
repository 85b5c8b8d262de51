"""Files of other programs that are damaged are refused, and what they lack is reported."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_foreign_formats import group_csv, merged_hdf5, original_json

ALL = len(POINTS)

VICTIM = 7
NOT_COMPLETE, REFUSED = 1, 3


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(scope="module")
def cut_short(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("short"), ALL - 2, "stopped")


WRITERS = {
    "group-csv": lambda survey, path: group_csv.write_group_csv(survey, path),
    "original-json": lambda survey, path: original_json.write_original(survey, path),
    "merged-hdf5": lambda survey, path: merged_hdf5.write_merged(survey, path, "t"),
}


def bring_in(tmp_path, kind):
    output = tmp_path / "in.nc"
    status = main(["import", str(tmp_path / "there"), str(output), "--format", kind])
    return status, output.exists()


@pytest.mark.parametrize("place", np.linspace(0.05, 0.95, 10))
def test_a_changed_byte_of_a_merged_file_is_refused(whole, tmp_path, refusals, place):
    path = tmp_path / "there"
    WRITERS["merged-hdf5"](load_survey(whole), path)
    content = bytearray(path.read_bytes())
    content[int(len(content) * place)] ^= 0x10
    path.write_bytes(content)
    assert bring_in(tmp_path, "merged-hdf5") == (REFUSED, False)
    assert refusals[-1:] == [faults.FILE_CHANGED.code]


@pytest.mark.parametrize("kind", WRITERS)
def test_missing_samples_of_other_formats_are_told(cut_short, tmp_path, kind):
    WRITERS[kind](load_survey(cut_short), tmp_path / "there")
    assert bring_in(tmp_path, kind) == (NOT_COMPLETE, True)


@pytest.mark.parametrize("kind", ["group-csv", "original-json"])
@pytest.mark.parametrize("cut", [1, 20, None])
def test_files_of_other_formats_that_are_cut_short_are_refused(whole, tmp_path, kind, cut):
    WRITERS[kind](load_survey(whole), tmp_path / "there")
    victim = sorted((tmp_path / "there").iterdir())[VICTIM]
    victim.write_bytes(victim.read_bytes()[: -cut if cut else 0])
    assert bring_in(tmp_path, kind) == (REFUSED, False)


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: file.attrs.update({"Total Amount of A-Scans": 17}),
        lambda file: file["Frequency"].attrs.update(df=1e6),
        lambda file: file["Position"].attrs.update(dx=0.004),
        lambda file: file["A-Scan"].pop("Im{S21 x-pol}"),
        lambda file: file["A-Scan"].move("Re{S21 x-pol}", "Rx{S21 x-pol}"),
        lambda file: file["Position/h x-pol"].write_direct(np.full((9, 1), -0.2, np.float32)),
        lambda file: file["Position/h x-pol"].write_direct(np.full((9, 1), np.inf, np.float32)),
    ],
)
def test_a_merged_file_that_contradicts_itself_is_refused(whole, tmp_path, damage):
    path = tmp_path / "there"
    merged_hdf5.write_merged(load_survey(whole), path, "t")
    unsealed = path.read_bytes()[:-80]  # as the group's own files, which have no checksum
    path.write_bytes(unsealed)
    with h5py.File(path, "r+") as file:
        damage(file)
    assert bring_in(tmp_path, "merged-hdf5") == (REFUSED, False)
