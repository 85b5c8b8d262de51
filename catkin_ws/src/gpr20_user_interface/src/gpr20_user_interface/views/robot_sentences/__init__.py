"""What the robot says of itself, sentence by sentence, to be translated.

Sentences are told in rows with "; " between them; each entry is one of a row. A place to fill in
holds a value, or the sentence of a part whose words are known here as well.
"""

from __future__ import annotations

from typing import Tuple

from gpr20_user_interface.views.robot_sentences.axis_sentences import AXES
from gpr20_user_interface.views.robot_sentences.control_sentences import CONTROL
from gpr20_user_interface.views.robot_sentences.sensor_sentences import SENSORS
from gpr20_user_interface.views.robot_sentences.storage_sentences import STORAGE
from gpr20_user_interface.views.robot_sentences.surroundings_sentences import SURROUNDINGS

# In the order in which they are tried: those that match more come later.
SENTENCES: Tuple[str, ...] = (*CONTROL, *AXES, *SENSORS, *STORAGE, *SURROUNDINGS)
