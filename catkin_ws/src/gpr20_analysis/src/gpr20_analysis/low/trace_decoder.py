"""The message of a trace, decoded by the definition that its recording holds."""

from __future__ import annotations

from typing import Any, Dict, Tuple

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from gpr20_analysis.errors import UnreadableFileError

TRACE = "gpr20_msgs/msg/Trace"
DATATYPE = "gpr20_msgs/Trace"


class TraceDecoder:
    """Decodes serialized traces into their fields."""

    def __init__(self) -> None:
        self._stores: Dict[Tuple[str, str], Any] = {}

    def decode(self, data: bytes, definition: str, md5sum: str) -> Dict[str, Any]:
        """Return the fields of a trace.

        Args:
            data: The serialized message.
            definition: Full text of its type.
            md5sum: Checksum of its type.

        Raises:
            UnreadableFileError: The message, or its type, is damaged.
        """
        store = self._store(definition, md5sum)
        try:
            message = store.deserialize_ros1(data, TRACE)
        except Exception as error:
            # The library reads without checks and so fails in any way on damaged bytes.
            raise UnreadableFileError(f"a recorded trace is not whole: {error!r}") from error
        return {name: getattr(message, name) for name in store.types[TRACE].__annotations__}

    def _store(self, definition: str, md5sum: str) -> Any:
        key = (definition, md5sum)
        if key not in self._stores:
            store = get_typestore(Stores.ROS1_NOETIC)
            try:
                store.register({TRACE: get_types_from_msg(definition, TRACE)[TRACE]})
                own = store.generate_msgdef(TRACE)[1]
            except Exception as error:
                raise UnreadableFileError(f"the type of a trace is damaged: {error!r}") from error
            if own != md5sum:
                raise UnreadableFileError(
                    f"the type of a trace is damaged: its checksum is {own}, not {md5sum[:64]}"
                )
            self._stores[key] = store
        return self._stores[key]
