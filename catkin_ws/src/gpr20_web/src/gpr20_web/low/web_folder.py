"""The folder of what nobody but the page may read: accounts, key and certificate."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import ipaddress
import os
import shutil
import socket
import ssl
import stat
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.files.durable_files import ensure_folder, ensure_folders, write_new_file
from gpr20_survey.files.regular_files import read_regular
from gpr20_web.faults import SetupError

FOLDER_MODE = 0o700
KEY_NAME, CERTIFICATE_NAME = "key.pem", "certificate.pem"
PROGRAM = "openssl"
# Apple's browsers refuse certificates for longer, also those that a person has accepted.
VALID_DAYS = 825
_BEGIN = b"-----BEGIN CERTIFICATE-----"
# No authority: Firefox refuses a page that shows the certificate of one.
_REQUEST = """\
[req]
prompt = no
distinguished_name = name
x509_extensions = use
[name]
CN = GPR-20
[use]
basicConstraints = critical, CA:FALSE
keyUsage = critical, digitalSignature
extendedKeyUsage = serverAuth
subjectKeyIdentifier = hash
subjectAltName = {names}
"""


@dataclass(frozen=True)
class Certificate:
    """What shows browsers that it is this page.

    Attributes:
        certificate: Its file.
        key: The file of its key.
        fingerprint: SHA-256 of the certificate, for people who compare it with what their
            browser shows.
        cookie_key: What signs the cookies of the logins; another key has another one.
    """

    certificate: Path
    key: Path
    fingerprint: str
    cookie_key: bytes


def ensure_secret_folder(folder: Path) -> None:
    """Make the folder if it is missing; let nobody but its owner into it.

    Raises:
        SetupError: It belongs to another user, who could not read what is written now; or the
            disk refused.
    """
    try:
        # Another program may make it meanwhile; what is no folder is refused below.
        with contextlib.suppress(FileExistsError):
            ensure_folders(folder.parent)
            ensure_folder(folder, FOLDER_MODE)
        found = folder.stat()
        if not stat.S_ISDIR(found.st_mode):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
        if found.st_uid == os.geteuid():
            folder.chmod(FOLDER_MODE)
            return
        reason = Message("it belongs to the user {number}", number=found.st_uid)
    except OSError as error:
        reason = os_reason(error)
    raise SetupError(
        Message(
            "the folder of the page cannot be used: {reason}; set folder in web.yaml to one that "
            "the page may write",
            reason=reason,
            details=printable(folder),
        )
    )


def ensure_certificate(folder: Path, names: Sequence[str]) -> Certificate:
    """Return key and certificate; make them if neither is there, and change none that is.

    Args:
        folder: Of the page.
        names: Addresses of this computer besides its host name and localhost.

    Raises:
        SetupError: They cannot be made or used, or are no longer valid.
    """
    key, path = folder / KEY_NAME, folder / CERTIFICATE_NAME
    ensure_secret_folder(folder)
    try:
        if not key.exists() and not path.exists():
            _make(key, path, names)
        pem = read_regular(path).decode("ascii")
        digest = hashlib.sha256(ssl.PEM_cert_to_DER_cert(pem)).hexdigest().upper()
        shown = " ".join(digest[at : at + 4] for at in range(0, len(digest), 4))
        cookie_key = hashlib.sha256(b"cookies" + read_regular(key)).digest()
        found = Certificate(path, key, shown, cookie_key)
        ssl_context(found)
        if _openssl("x509", "-noout", "-checkend", "0", "-in", str(path)).returncode == 0:
            return found
        reason = Message("the certificate is no longer valid")
    except (OSError, ValueError) as error:
        if isinstance(error, SetupError):
            raise
        said = os_reason(error) if isinstance(error, OSError) else str(error)
        reason = Message("{reason}", reason=said)
    raise SetupError(
        Message(
            "{key} and {certificate} in {folder} cannot be used: {reason}; move both away, and the "
            "page makes others, which every browser must accept again",
            key=KEY_NAME,
            certificate=CERTIFICATE_NAME,
            folder=printable(folder),
            reason=reason,
        )
    )


def ssl_context(certificate: Certificate) -> ssl.SSLContext:
    """Return what the server encrypts with.

    Raises:
        OSError: The files are no key and certificate that belong together.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    # With a passphrase it would ask on the terminal.
    context.load_cert_chain(str(certificate.certificate), str(certificate.key), password="")
    return context


def _make(key: Path, certificate: Path, names: Sequence[str]) -> None:
    addresses = (ipaddress.ip_address(one) for one in ("127.0.0.1", "::1", *names))
    shown = [f"IP:{one}" for one in addresses if not one.is_unspecified]
    shown += [f"DNS:{one}" for one in (socket.gethostname(), "localhost")]
    made = _openssl(
        *("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
        *("-sha256", "-nodes", "-days", str(VALID_DAYS), "-config", "/dev/stdin"),
        stdin=_REQUEST.format(names=",".join(shown)),
    )
    begin = made.stdout.find(_BEGIN)
    if made.returncode != 0 or begin < 0:
        complaint = made.stderr.decode("utf-8", "backslashreplace").strip()
        raise SetupError(Message("openssl made no certificate", details=complaint))
    write_new_file(key, made.stdout[:begin])
    write_new_file(certificate, made.stdout[begin:])


def _openssl(*arguments: str, stdin: str = "") -> subprocess.CompletedProcess[bytes]:
    program = shutil.which(PROGRAM)
    if program is None:
        raise SetupError(Message("the program {program} is not installed", program=PROGRAM))
    given = stdin.encode()
    return subprocess.run([program, *arguments], input=given, capture_output=True, check=False)
