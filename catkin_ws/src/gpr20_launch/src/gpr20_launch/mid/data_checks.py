"""Whether a robot can keep its surveys where its configuration says."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Iterator, Optional, Tuple

from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_launch.mid.problem import Problem, problem
from gpr20_launch.mid.robot_files import Reading, Use
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.folder.data_folder import IN_MEMORY, DataFolder, existing_folder, file_system_of
from gpr20_survey.folder.signature import key_warning
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB, ProcessingParameters

STORAGE_FILE = "storage.yaml"
# Folders of the system, and those that it empties.
OF_SYSTEM = ("/bin", "/boot", "/dev", "/etc", "/lib", "/proc", "/sbin", "/sys", "/usr")
EMPTIED = ("/tmp", "/var/tmp", "/var/cache")
OF_MEDIA = ("/media", "/mnt", "/run/media")
ORDER = "; data:= of a launch counts before data: in storage.yaml, and that before GPR20_DATA"


def check_data(reading: Reading, use: Use) -> Iterator[Problem]:
    """Find why surveys cannot be stored, or hardly, in the folder that counts."""
    storage, file = reading.record("storage"), str(reading.folder / STORAGE_FILE)
    if "storage" in reading.unsure:
        return
    sources = (
        (use.data.strip(), "data:=", "data"),
        (storage.data.strip(), file, "data"),
        (use.environment.get("GPR20_DATA", "").strip(), "environment", "GPR20_DATA"),
    )
    text, place, key = next((one for one in sources if one[0]), ("", file, "data"))
    # A relative one depends on the folder in which the robot is started.
    absolute = place == "data:=" or text[:1] in "/~"
    if not (absolute and text.isprintable() and "~" not in os.path.expanduser(text)[:1]):
        allowed = "an absolute path, such as /srv/gpr20/surveys"
        yield problem(place, key, text, "no folder is meant by this" + ORDER, allowed)
        return
    storage = replace(storage, data=text)
    mistake = _mistake(storage, reading.folder, use.real)
    reason = mistake or (_doubt(storage) if text else "")
    if reason:
        allowed = "a folder of its own on a disk, such as ~/gpr20_data"
        yield problem(place, key, storage.data_folder(), reason + ORDER, allowed, not mistake)
    if not mistake:
        yield from _disk(storage, (place, key), file)


def _mistake(storage: ProcessingParameters, configuration: Path, real: bool) -> str:
    folder = storage.data_folder()
    inside = {folder, *folder.parents}
    if folder in (Path("/"), Path.home()) or inside & set(map(Path, OF_SYSTEM)):
        return "this folder belongs to the system"
    if str(folder) in EMPTIED:
        return "this folder belongs to every program, and the system empties it"
    if folder.exists() and not folder.is_dir():
        return "it is no folder"
    if configuration in inside:
        return "this folder holds the configuration"
    if real and file_system_of(existing_folder(folder)).kind in IN_MEMORY:
        return "this folder is in memory: surveys are lost when the robot is off"
    return ""


def _doubt(storage: ProcessingParameters) -> str:
    folder = storage.data_folder()
    inside = [folder, *folder.parents]
    if {*map(str, inside)} & {*EMPTIED} - {*map(str, Path.home().parents)}:
        return "the system empties this folder"
    if {*map(str, inside)} & {*OF_MEDIA} and not storage.data_disk:
        return (
            "without its medium, surveys would be stored on the disk of the system, unless "
            f"data_disk: true is in {STORAGE_FILE}"
        )
    checkout: Optional[Path] = next((one for one in inside if (one / ".git").exists()), None)
    if checkout is not None:
        return f"it is inside of the repository {checkout}, which people clean and replace"
    if not folder.exists():
        mount_point = file_system_of(existing_folder(folder)).mount_point
        return (
            "it does not exist; unless its disk is mounted before, a launch makes it on the file "
            f"system of {mount_point}"
        )
    return ""


def _disk(storage: ProcessingParameters, where: Tuple[str, str], file: str) -> Iterator[Problem]:
    use = storage.data_folder_use()
    try:
        DataFolder(use).identify()
    except ProcessingError as error:
        yield Problem(error.message, *where, printable(use.path))
        return
    free_mb = free_bytes(existing_folder(use.path)) / BYTES_PER_MB
    if free_mb < storage.disk_reserve_mb:
        reason = f"{free_mb:.0f} MB are free there, so no survey can start"
        key, value = "disk_reserve_mb", f"{storage.disk_reserve_mb:g} MB"
        yield problem(file, key, value, reason, f"<= {free_mb:.0f} MB", True, DISK_FULL)
    unsigned = key_warning(storage.signer())
    if unsigned is not None:
        text = Message("{file}: {reason}", file=printable(file), reason=unsigned)
        yield Problem(text, file, "signing_key", storage.signing_key)
