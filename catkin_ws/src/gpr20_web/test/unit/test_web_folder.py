"""Key and certificate of the page: made once, never changed, refused when they are over."""

from __future__ import annotations

import hashlib
import shutil
import socket
import ssl
import stat
import subprocess
from pathlib import Path

import pytest

from gpr20_web.faults import SetupError
from gpr20_web.low.web_folder import Certificate, ensure_certificate, ssl_context

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl is not there")
ADDRESSES = ["192.168.1.10", "fd00::7"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Certificate:
    return ensure_certificate(tmp_path_factory.mktemp("home") / ".gpr20" / "web", ADDRESSES)


@pytest.fixture
def folder(made: Certificate, tmp_path: Path) -> Path:
    """Return a folder with a copy of both files."""
    shutil.copytree(str(made.key.parent), str(tmp_path / "web"))
    return tmp_path / "web"


def test_it_is_of_p_256_for_a_server_no_authority_and_every_name_of_this_computer(
    made: Certificate,
) -> None:
    command = ["openssl", "x509", "-noout", "-text", "-in", str(made.certificate)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    names = (f"DNS:{socket.gethostname()}", "DNS:localhost", "127.0.0.1", ADDRESSES[0])
    for part in ("prime256v1", "CA:FALSE", "TLS Web Server Authentication", *names):
        assert part in text
    der = ssl.PEM_cert_to_DER_cert(made.certificate.read_text())
    assert made.fingerprint.replace(" ", "").lower() == hashlib.sha256(der).hexdigest()


def test_what_is_there_stays_and_only_its_owner_reads_it(folder: Path, made: Certificate) -> None:
    assert stat.S_IMODE(made.key.stat().st_mode) == 0o600
    assert ssl_context(made).minimum_version is ssl.TLSVersion.TLSv1_2
    folder.chmod(0o755)
    before = {one.name: one.read_bytes() for one in folder.iterdir()}
    again = ensure_certificate(folder, ["10.0.0.1"])
    assert (again.fingerprint, again.cookie_key) == (made.fingerprint, made.cookie_key)
    assert {one.name: one.read_bytes() for one in folder.iterdir()} == before
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    shutil.rmtree(str(folder))
    other = ensure_certificate(folder, [])
    assert other.cookie_key != made.cookie_key and len(other.cookie_key) == 32


def test_one_without_the_other_another_key_and_damaged_files_are_refused_and_stay(
    folder: Path, tmp_path: Path
) -> None:
    whole = {one: one.read_bytes() for one in folder.iterdir()}
    other = ensure_certificate(tmp_path / "other", []).key.read_bytes()
    damages = [(one, bad) for one in whole for bad in (None, b"", b"\xff" * 40)]
    for damaged, content in (*damages, (folder / "key.pem", other)):
        for one, good in whole.items():
            one.write_bytes(good)
        damaged.unlink() if content is None else damaged.write_bytes(content)
        before = {one: one.read_bytes() for one in folder.iterdir()}
        with pytest.raises(SetupError, match="move both away"):
            ensure_certificate(folder, [])
        assert {one: one.read_bytes() for one in folder.iterdir()} == before


def test_a_certificate_that_is_over_is_not_renewed_and_a_passphrase_not_asked_for(
    folder: Path, made: Certificate
) -> None:
    certificate, key = folder / "certificate.pem", folder / "key.pem"
    command = ["openssl", "x509", "-in", str(certificate), "-signkey", str(key), "-days"]
    signed = subprocess.run([*command, "9"], capture_output=True, check=True).stdout
    certificate.write_bytes(signed)
    # Cookies are signed with what nobody else has: the certificate is public.
    assert ensure_certificate(folder, []).cookie_key == made.cookie_key
    signed = subprocess.run([*command, "0"], capture_output=True, check=True).stdout
    certificate.write_bytes(signed)
    with pytest.raises(SetupError, match="no longer valid; move both away"):
        ensure_certificate(folder, [])
    assert certificate.read_bytes() == signed
    command = ["openssl", "ec", "-aes256", "-passout", "pass:secret", "-in", str(key)]
    key.write_bytes(subprocess.run(command, capture_output=True, check=True).stdout)
    with pytest.raises(SetupError):
        ensure_certificate(folder, [])
