"""Recipes as YAML files."""

from __future__ import annotations

from pathlib import Path

import yaml

from gpr20_analysis.errors import RecipeError


def read_recipe(path: Path) -> object:
    """Return what a YAML file holds.

    Raises:
        RecipeError: It is not YAML.
        OSError: It cannot be read.
    """
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise RecipeError(f"{path} is not YAML: {error}") from error


def recipe_text(recipe: object) -> str:
    """Return a recipe as YAML."""
    return yaml.safe_dump(recipe, sort_keys=False)
