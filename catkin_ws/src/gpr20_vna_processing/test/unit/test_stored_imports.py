"""The storage lists and reads surveys that were imported, and never continues one."""

import pytest
from fault_kit import raises_fault
from imported_kit import imported_folder
from storage_kit import Kit

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.results.survey_summary import summary_fields
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.survey_archive import SurveyArchive


@pytest.fixture
def kit(tmp_path):
    kit = Kit(tmp_path)
    yield kit
    kit.processing.shut_down()


def contents(folder):
    return {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}


def test_it_is_listed_as_imported_with_its_source_and_its_area(tmp_path):
    folder = imported_folder(tmp_path, 6, 3)
    (survey,), _ = SurveyArchive(tmp_path).list("", 10)
    assert (survey.folder, survey.outcome, survey.problem) == (folder.name, "imported", None)
    assert (survey.stored_traces, survey.planned_traces) == (18, 0)
    assert not survey.complete and not survey.simulated
    assert str(survey.verdict) == "imported from line 7.dzt (dzt)"
    area = survey.thumbnail
    assert (area.width_mm, area.height_mm, area.columns, area.rows) == (100.0, 200.0, 6, 3)
    assert set(area.percent) == {100}
    assert summary_fields(survey)["outcome"] == "imported"


def test_its_traces_are_read(tmp_path):
    archive = SurveyArchive(tmp_path)
    folder = imported_folder(tmp_path, 6, 3)
    assert archive.survey(folder.name).stored_indices == tuple(range(18))
    found = archive.traces(folder.name, range(4, 11))
    assert found.block.indices.tolist() == list(range(4, 11)) and not found.unreadable


def test_it_is_not_continued_and_nothing_in_it_changes(kit, tmp_path):
    folder = imported_folder(tmp_path)
    (folder / "traces" / "000003_X0060.00_Y0000.00_Z+000.00.json").unlink()
    before = contents(folder)
    with raises_fault(faults.IMPORTED, "was imported; it has no plan"):
        kit.processing.reopen_survey(folder.name)
    assert contents(folder) == before


def test_a_note_can_be_added_to_it(kit, tmp_path):
    folder = imported_folder(tmp_path)
    kit.processing.annotate(folder.name, Annotation(name="Line 7"))
    (survey,), _ = SurveyArchive(tmp_path).list("", 10)
    assert survey.name == "Line 7"
    assert verify_survey(folder).faults == []
