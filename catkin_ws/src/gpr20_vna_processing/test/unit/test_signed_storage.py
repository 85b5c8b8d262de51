"""The storage signs what it closes, and nothing that somebody else has changed."""

import pytest
from storage_kit import Kit, make_key, signers_line
from trace_examples import METADATA, SURVEY, planned_trace

from gpr20_analysis.read.signature import Signature, check_signature
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.manifest import MANIFEST_FILE as SEAL
from gpr20_survey.folder.recovery import Fact, add_to_survey, read_description
from gpr20_survey.folder.signature import SIGNATURE_FILE
from gpr20_survey.plan.annotation import Annotation

NOW = "2026-11-25T00:00:00.000000Z"
TRACES = 9


@pytest.fixture
def signers(tmp_path):
    """The signers file that accepts the key `key` beside it."""
    make_key(tmp_path / "key")
    path = tmp_path / "signers"
    path.write_text(signers_line(tmp_path / "key"))
    return path


@pytest.fixture
def kit(tmp_path, signers):
    kit = Kit(tmp_path / "data", signing_key=str(tmp_path / "key"))
    yield kit
    kit.processing.shut_down()


def stopped(kit):
    folder = kit.open(metadata_json=METADATA)
    for index in range(TRACES - 1):
        kit.processing.store(planned_trace(index))
    kit.processing.close_survey(SURVEY, "stopped")
    return folder


def finish(kit):
    kit.processing.reopen_survey(SURVEY)
    kit.processing.store(planned_trace(TRACES - 1))
    kit.processing.close_survey(SURVEY, "finished")


def test_a_survey_is_signed_at_its_end_and_what_is_added_later_is_not(kit, signers):
    folder = stopped(kit)
    assert check_signature(folder, signers).state is Signature.VALID
    for kind in (Kind.EXPORT, Kind.BAG):  # these say of copies alone
        add_to_survey(folder, lambda _description, kind=kind: Fact(kind, {"time": NOW}), NOW)
    assert check_signature(folder, signers).state is Signature.VALID
    kit.annotate(SURVEY, Annotation(name="field 7"))
    assert check_signature(folder, signers).state is Signature.CHANGED
    finish(kit)
    assert check_signature(folder, signers).state is Signature.VALID
    assert kit.processing.state().unsigned is None
    assert "unconfirmed" not in read_description(folder)


def test_a_key_that_is_gone_does_not_keep_a_survey_open(kit, tmp_path, signers):
    (tmp_path / "key").unlink()
    folder = stopped(kit)
    assert check_signature(folder, signers).state is Signature.UNSIGNED
    assert kit.processing.state().unsigned.fault_code == "survey.not_signed"


@pytest.mark.parametrize("lost", [(SEAL,), (SIGNATURE_FILE,), (SEAL, SIGNATURE_FILE), "{}"])
def test_a_survey_whose_signature_is_gone_is_named_for_ever(kit, signers, lost):
    folder = stopped(kit)
    if lost == "{}":
        (folder / SEAL).write_bytes(b"{}")
    else:
        for name in lost:
            (folder / name).unlink()
    finish(kit)
    assert check_signature(folder, signers).state is Signature.VALID
    assert set(read_description(folder)["unconfirmed"]) == {"signature"}
