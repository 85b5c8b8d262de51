"""The storage signs what it closes and changes, and nothing that somebody else has changed."""

import pytest
from planned_survey import METADATA, planned_trace
from storage_kit import Kit
from trace_examples import SURVEY

from gpr20_survey.files import ssh_keygen
from gpr20_survey.folder.annotating import add_to_survey, annotate
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.manifest import MANIFEST_FILE as SEAL
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.folder.signature import (
    NAMESPACE,
    SIGNATURE_FILE,
    Signature,
    Signer,
    check_signature,
)
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.recording.recordings import open_recordings

NOW = "2026-11-25T00:00:00.000000Z"
TRACES = 9


@pytest.fixture
def signers(tmp_path):
    """The signers file that accepts the key `key` beside it."""
    ssh_keygen.make_key(tmp_path / "key", "robot")
    path = tmp_path / "signers"
    path.write_text(ssh_keygen.public_key(tmp_path / "key").signers_line("robot", NAMESPACE))
    return path


@pytest.fixture
def kit(tmp_path, signers):
    kit = Kit(tmp_path / "data", open_recordings, signer=Signer(tmp_path / "key"))
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


def test_a_survey_is_signed_at_its_end_and_at_each_later_change(kit, signers):
    folder = stopped(kit)
    assert check_signature(folder, signers).signature is Signature.VALID
    kit.processing.annotate(SURVEY, Annotation(name="field 7"))
    assert check_signature(folder, signers).signature is Signature.VALID
    finish(kit)
    assert check_signature(folder, signers).signature is Signature.VALID
    assert kit.processing.state().unsigned is None
    assert "unconfirmed" not in read_description(folder)


def test_what_somebody_else_has_sealed_is_not_signed_before_it_is_named_for_ever(kit, signers):
    folder = stopped(kit)
    add_to_survey(folder, annotate(Annotation(name="not by the robot")), NOW)
    kit.processing.annotate(SURVEY, Annotation(name="field 7"))
    assert check_signature(folder, signers).signature is Signature.STALE
    finish(kit)
    assert check_signature(folder, signers).signature is Signature.VALID
    assert "signature" in read_description(folder)["unconfirmed"]


def test_a_key_that_is_gone_does_not_keep_a_survey_open(kit, tmp_path, signers):
    (tmp_path / "key").unlink()
    folder = stopped(kit)
    assert check_signature(folder, signers).signature is Signature.UNSIGNED
    assert kit.processing.state().unsigned.fault_code == "survey.signing_key"


@pytest.mark.parametrize("lost", [(), (SEAL,), (SIGNATURE_FILE,), (SEAL, SIGNATURE_FILE), "{}"])
def test_what_somebody_added_without_the_key_is_named_for_ever(kit, signers, lost):
    folder = stopped(kit)
    records = recover(folder).found.records
    log = SurveyLog(folder, records, whole=True)
    log.add(log.next(Kind.ANNOTATION, {"name": "not by the robot"}, NOW))
    if lost == "{}":
        (folder / SEAL).write_bytes(b"{}")
    else:
        for name in lost:
            (folder / name).unlink()
    finish(kit)
    assert check_signature(folder, signers).signature is Signature.VALID
    named = {"log"} if SEAL not in lost and lost != "{}" else set()
    named |= {"signature"} if lost else set()
    assert set(read_description(folder)["unconfirmed"]) == named
