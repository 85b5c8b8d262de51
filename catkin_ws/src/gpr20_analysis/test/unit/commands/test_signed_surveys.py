"""gpr20 verify --signers says who vouches for a survey; gpr20 sign signs it as it is now."""

import json

import pytest
from storage_kit import fingerprint, make_key, signers_line
from survey_kit import contents, make_survey

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey import faults as survey_faults
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.signature import SIGNATURE_FILE, Signer
from gpr20_survey.folder.survey_log import SurveyLog


@pytest.fixture(scope="module")
def keys(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys")
    for name in ("robot", "other"):
        make_key(folder / name)
    (folder / "signers").write_text(signers_line(folder / "robot"))
    return folder


@pytest.fixture
def folder(copied, keys):
    Signer(keys / "robot").sign(copied)
    return copied


@pytest.fixture
def verify(keys, capsys):
    """Return what verify finds of a survey: exit status, state of the signature and code."""

    def verified(folder, *more):
        capsys.readouterr()
        asked = ["--signers", str(keys / "signers")]
        status = main(["verify", str(folder), "--json", *asked, *more])
        record = json.loads(capsys.readouterr().out)
        assert record["status"] == status
        found = record["signature"]
        return status, found["state"], found["fault"].get("code", "")

    return verified


def test_a_signed_survey_names_its_signer_last(folder, keys, capsys):
    assert main(["verify", str(folder), "--signers", str(keys / "signers")]) == 0
    complete, signed = capsys.readouterr().out.splitlines()
    assert complete.startswith("complete and intact")
    assert signed == f"signed by robot with the key {fingerprint(keys / 'robot')}"
    # A word of praise for what is signed is not one for what was measured.
    (folder / "survey.bag").write_bytes(b"")
    assert main(["verify", str(folder), "--signers", str(keys / "signers")]) == 2


def test_without_signers_a_signature_is_only_noted(folder, capsys):
    assert main(["verify", str(folder)]) == 0
    assert "note: signed; by whom was not checked" in capsys.readouterr().out
    (folder / SIGNATURE_FILE).unlink()
    assert main(["verify", str(folder)]) == 0
    assert "note: not signed" in capsys.readouterr().out


def test_what_nobody_on_the_list_signed_or_nobody_ended_is_never_complete(
    folder, keys, verify, tmp_path
):
    assert verify(folder) == (0, "valid", "")
    manifest = folder / "manifest.json"
    sealed, signature = manifest.read_bytes(), (folder / SIGNATURE_FILE).read_bytes()

    manifest.write_bytes(sealed.replace(b"finished", b"finishes") + b" ")
    assert verify(folder) == (2, "wrong", errors.WRONG_SIGNATURE.code)
    manifest.write_bytes(sealed)
    (folder / SIGNATURE_FILE).write_bytes(signature[:-9])
    assert verify(folder) == (2, "wrong", errors.WRONG_SIGNATURE.code)
    Signer(keys / "other").sign(folder)
    assert verify(folder) == (2, "unknown key", errors.UNKNOWN_SIGNER.code)
    (folder / SIGNATURE_FILE).unlink()
    assert verify(folder) == (1, "unsigned", errors.UNSIGNED.code)
    stopped = make_survey(tmp_path / "stopped", 7, "stopped")
    Signer(keys / "robot").sign(stopped)
    assert verify(stopped) == (1, "valid", "")


def test_what_is_added_is_not_signed_before_somebody_signs(folder, keys, verify, capsys):
    key = str(keys / "robot")
    assert main(["annotate", str(folder), "--site", "here"]) == 0
    changed = "changed after it was signed"
    assert verify(folder) == (1, changed, errors.CHANGED_SINCE_SIGNED.code)
    assert main(["sign", str(folder), key]) == 0
    assert "signed as it is now" in capsys.readouterr().out
    assert verify(folder) == (0, "valid", "")
    (folder / "manifest.json").unlink()
    assert verify(folder)[:2] == (2, "unsigned")
    assert main(["verify", "--repair", str(folder)]) == 0
    assert verify(folder)[:2] == (2, "wrong")
    assert main(["sign", str(folder), key]) == 0
    assert verify(folder) == (0, "valid", "")


def test_what_differs_and_what_is_not_closed_is_not_signed(folder, keys, tmp_path, refusals):
    before, key, none = contents(folder), str(keys / "robot"), str(tmp_path / "none")
    assert main(["sign", str(folder), none]) == 3
    assert main(["verify", str(folder), "--signers", none]) == 3
    (folder / "manifest.json").rename(tmp_path / "manifest.json")
    assert main(["sign", str(folder), key]) == 3
    (tmp_path / "manifest.json").rename(folder / "manifest.json")
    assert contents(folder) == before
    (folder / "survey.json").write_bytes(b"{}")
    assert main(["sign", str(folder), key]) == 3
    codes = [survey_faults.NOT_SIGNED, NOT_ALLOWED, CAN_RESUME, errors.NOT_INTACT]
    assert refusals == [one.code for one in codes]


def test_a_survey_that_was_reopened_is_not_as_it_was_signed(folder, verify):
    """Whoever adds that entry could have changed any file."""
    log = SurveyLog(folder, recover(folder).found.records, whole=True)
    log.add(log.next(Kind.RESUME, {"stored_traces": 18}, "2026"))
    assert verify(folder)[:2] == (2, "wrong")
