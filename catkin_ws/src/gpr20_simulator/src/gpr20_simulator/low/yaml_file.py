"""A YAML file."""

from __future__ import annotations

from typing import Any

import yaml


def read_yaml(path: str) -> Any:
    """Return what a YAML file holds.

    Raises:
        OSError: The file cannot be read.
        ValueError: The file is not YAML; the message says where.
    """
    with open(path, encoding="utf-8") as stream:
        try:
            return yaml.safe_load(stream)
        except yaml.YAMLError as error:
            raise ValueError(str(error)) from error
