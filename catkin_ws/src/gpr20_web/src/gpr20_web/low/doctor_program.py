"""The doctor as a program of its own, which makes the bundle for remote help."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from gpr20_common.message import Message
from gpr20_web.errors import BundleError

LIMIT_S = 180.0
# In another process: the doctor gives itself the least priority for good.
PROGRAM = "import sys; from gpr20_doctor.high.doctor import main; sys.exit(main())"


def make_bundle(namespace: str) -> bytes:
    """Return a bundle for the robot of a namespace; no instrument is tested.

    Raises:
        BundleError: The doctor made none.
    """
    with tempfile.TemporaryDirectory(prefix="gpr20_web_") as folder:
        file = Path(folder) / "bundle.zip"
        words = [sys.executable, "-c", PROGRAM, "--quick", f"--ns={namespace}", f"--bundle={file}"]
        quiet = subprocess.DEVNULL
        try:
            # Its exit status says what is wrong with the robot, not whether there is a bundle.
            subprocess.run(words, stdin=quiet, stdout=quiet, timeout=LIMIT_S, check=False)
            return file.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            said = Message("the doctor made no bundle", details=type(error).__name__)
            raise BundleError(said) from error
