"""Passwords, kept as hashes by scrypt."""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
import unicodedata
from dataclasses import dataclass, replace

from gpr20_common.message import Message
from gpr20_common.terminal_text import is_shown
from gpr20_web.errors import AccountError

SHORTEST, LONGEST = 12, 200
LEAST_DIFFERENT = 5
HASH_BYTES = 32


@dataclass(frozen=True)
class PasswordHash:
    """What is kept of a password; its effort is kept with it, so that another can follow.

    The defaults are what OWASP recommends for 32 MiB.

    Attributes:
        n: A power of two; like r and p a parameter of scrypt.
        key: What scrypt has made of password and salt. The default fits no password.
    """

    n: int = 1 << 15
    r: int = 8
    p: int = 3
    salt: bytes = b""
    key: bytes = b""

    def of(self, password: str) -> PasswordHash:
        """Hash a password with the same effort, which takes a part of a second."""
        salted = replace(self, salt=secrets.token_bytes(HASH_BYTES))
        return replace(salted, key=salted._key_of(password))

    def fits(self, password: str) -> bool:
        """Return whether it is the hash of this password."""
        return hmac.compare_digest(self._key_of(password), self.key)

    def __str__(self) -> str:
        salt, key = (base64.b64encode(one).decode() for one in (self.salt, self.key))
        return f"scrypt:{self.n}:{self.r}:{self.p}:{salt}:{key}"

    @classmethod
    def parse(cls, text: str) -> PasswordHash:
        """Return what `str` wrote.

        Raises:
            ValueError: The text is anything else, or asks for more than this computer has.
        """
        n, r, p = (int(one) for one in text.split(":")[1:4])
        salt, key = (base64.b64decode(one, validate=True) for one in text.split(":")[4:])
        if not (1 < n <= 1 << 20 and n & (n - 1) == 0 and 1 <= r <= 32 and 1 <= p <= 16):
            raise ValueError("n, r or p is out of bounds")
        made = cls(n, r, p, salt, key)
        if str(made) != text or len(key) != HASH_BYTES:
            raise ValueError("this is no hash of a password")
        return made

    def _key_of(self, password: str) -> bytes:
        return hashlib.scrypt(
            # Keyboards write the same letter with an accent in two ways.
            unicodedata.normalize("NFC", password).encode("utf-8", "surrogatepass"),
            salt=self.salt,
            n=self.n,
            r=self.r,
            p=self.p,
            # What it needs, and a little for OpenSSL itself.
            maxmem=128 * self.r * (self.n + self.p + 2) + (1 << 20),
            dklen=HASH_BYTES,
        )


def check_password(password: str, name: str) -> None:
    """Refuse a new password that is easy to guess; where it is long no other rule is needed.

    Raises:
        AccountError: It is not allowed for the account of this name.
    """
    text = unicodedata.normalize("NFC", password)
    if not (SHORTEST <= len(text) <= LONGEST and len(set(text)) >= LEAST_DIFFERENT):
        raise AccountError(
            Message(
                "the password has {length} characters, {different} different ones; it must have "
                "{shortest} to {longest}, at least {least} different ones",
                length=len(text),
                different=len(set(text)),
                shortest=SHORTEST,
                longest=LONGEST,
                least=LEAST_DIFFERENT,
            )
        )
    if password.casefold() == name.casefold():
        raise AccountError(Message("the password must not be the name"))
    if not all(map(is_shown, password)):
        raise AccountError(
            Message(
                "the password has control characters; it may have letters, digits, signs and spaces"
            )
        )
