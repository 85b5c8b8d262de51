"""Recipes as YAML files."""

from __future__ import annotations

from pathlib import Path

import yaml

from gpr20_analysis.errors import RecipeError
from gpr20_common.low.yaml_file import YamlFileError, read_yaml


def read_recipe(path: Path) -> object:
    """Return what a YAML file holds.

    Raises:
        RecipeError: It is not YAML.
        OSError: It cannot be read.
    """
    try:
        return read_yaml(path)
    except YamlFileError as error:
        raise RecipeError(f"{path} is no recipe: {error}") from error


def recipe_text(recipe: object) -> str:
    """Return a recipe as YAML."""
    return yaml.safe_dump(recipe, sort_keys=False)
