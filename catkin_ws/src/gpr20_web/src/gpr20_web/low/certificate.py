"""Key and certificate of the page, made once at the installation by the program openssl."""

from __future__ import annotations

import hashlib
import ipaddress
import re
import shutil
import socket
import ssl
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_web.errors import CertificateError, WebError
from gpr20_web.low.secret_folder import ensure_secret_folder

PROGRAM = "openssl"
KEY_NAME, CERTIFICATE_NAME = "key.pem", "certificate.pem"
# Apple's browsers refuse certificates for longer, also those that a person has accepted.
VALID_DAYS = 825
_BEGIN = b"-----BEGIN CERTIFICATE-----"
_HOST = re.compile("[A-Za-z0-9_]([A-Za-z0-9_.-]{0,251}[A-Za-z0-9_])?")
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
    """

    certificate: Path
    key: Path
    fingerprint: str


def ensure_certificate(folder: Path, names: Sequence[str]) -> Certificate:
    """Return key and certificate; make them if neither is there, and change none that is.

    Args:
        folder: Of the page.
        names: Names and addresses of this computer besides its host name and localhost.

    Raises:
        CertificateError: They cannot be made or used, or are no longer valid.
        FolderError: The folder cannot be used.
    """
    key, path = folder / KEY_NAME, folder / CERTIFICATE_NAME
    try:
        ensure_secret_folder(folder)
        if not key.exists() and not path.exists():
            made = _openssl(
                *("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
                *("-sha256", "-nodes", "-days", str(VALID_DAYS), "-config", "/dev/stdin"),
                stdin=_REQUEST.format(names=_alternatives(names)),
            )
            begin = made.stdout.find(_BEGIN)
            if made.returncode != 0 or begin < 0:
                complaint = made.stderr.decode("utf-8", "backslashreplace").strip()
                raise CertificateError(Message("openssl made no certificate", details=complaint))
            write_new_file(key, made.stdout[:begin])
            write_new_file(path, made.stdout[begin:])
        found = Certificate(path, key, _fingerprint(read_regular(path)))
        ssl_context(found)
        ended = _openssl("x509", "-noout", "-checkend", "0", "-in", str(path)).returncode != 0
    except (OSError, ValueError) as error:
        if isinstance(error, WebError):
            raise
        reason = os_reason(error) if isinstance(error, OSError) else str(error)
        raise _unusable(folder, Message("{reason}", reason=reason)) from error
    if ended:
        raise _unusable(folder, Message("the certificate is no longer valid"))
    return found


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


def _alternatives(names: Sequence[str]) -> str:
    """Return what the certificate is for, as openssl takes it."""
    found = []
    for one in dict.fromkeys([socket.gethostname(), "localhost", "127.0.0.1", "::1", *names]):
        try:
            if not ipaddress.ip_address(one).is_unspecified:
                found.append(f"IP:{one}")
        except ValueError as error:
            if not _HOST.fullmatch(one):
                text = Message(
                    "{name} is no name of a computer; it may have letters a-z, digits, hyphens, "
                    "underscores and full stops",
                    name=repr(one[:80]),
                )
                raise CertificateError(text) from error
            found.append(f"DNS:{one}")
    return ",".join(found)


def _fingerprint(pem: bytes) -> str:
    digest = hashlib.sha256(ssl.PEM_cert_to_DER_cert(pem.decode("ascii"))).hexdigest().upper()
    return " ".join(digest[at : at + 4] for at in range(0, len(digest), 4))


def _openssl(*arguments: str, stdin: str = "") -> subprocess.CompletedProcess[bytes]:
    program = shutil.which(PROGRAM)
    if program is None:
        raise CertificateError(Message("the program {program} is not installed", program=PROGRAM))
    given = stdin.encode()
    return subprocess.run([program, *arguments], input=given, capture_output=True, check=False)


def _unusable(folder: Path, reason: Message) -> CertificateError:
    return CertificateError(
        Message(
            "{key} and {certificate} in {folder} cannot be used: {reason}; move both away, and the "
            "page makes others, which every browser must accept again",
            key=KEY_NAME,
            certificate=CERTIFICATE_NAME,
            folder=printable(folder),
            reason=reason,
        )
    )
