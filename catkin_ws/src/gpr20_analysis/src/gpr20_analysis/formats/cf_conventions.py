"""What the CF conventions ask of a NetCDF file, so that other programs understand it.

Version 1.9 is the first with unsigned bytes and 64-bit integers.
"""

from __future__ import annotations

from typing import Any, Dict

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.formats.provenance import marked

CONVENTIONS = "CF-1.9"
AXES = {dataset.X: "X", dataset.Y: "Y", dataset.DEPTH: "Z"}
"""Of images alone: the conventions want these axes last, but spectra end with the frequency."""
PLANE = {dataset.X: "projection_x_coordinate", dataset.Y: "projection_y_coordinate"}
STANDARD_NAMES = {dataset.DEPTH: "depth", dataset.HEIGHT: "height", dataset.TIMESTAMP: "time"}
LONG_NAMES = {
    dataset.X: "position along X of the scanner",
    dataset.Y: "position along Y of the scanner",
    dataset.TIMESTAMP: "time of the sample, UTC",
    "sweep_started": "trigger of the sweep, UTC",
    "sweep_ended": "end of the sweep, UTC",
}
ANCILLARY = (dataset.QUALITY, dataset.HEIGHT, dataset.TIMESTAMP)


def with_conventions(stored: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with the attributes of the conventions; values are unchanged.

    Args:
        stored: Dataset without complex numbers.
    """
    data = stored.copy()
    is_image = dataset.DEPTH in data.dims
    for name in data.variables:
        word, own = str(name), data[name].attrs
        own.setdefault("long_name", LONG_NAMES.get(word, word.replace("_", " ")))
        if word in AXES and is_image:
            own["axis"] = AXES[word]
        if word in PLANE and is_image:
            own["standard_name"] = PLANE[word]
        if word == dataset.HEIGHT:
            own["positive"] = "up"
        if word in STANDARD_NAMES:
            own["standard_name"] = STANDARD_NAMES[word]
        if "flag_masks" in own:
            own["flag_masks"] = np.asarray(own["flag_masks"], data[name].dtype)
        if set(dataset.SAMPLE_DIMS) < set(data[name].dims):
            beside = [one for one in ANCILLARY if one in data]
            if beside:
                own["ancillary_variables"] = " ".join(beside)
    data.attrs.setdefault("Conventions", CONVENTIONS)
    title = f"GPR-20 survey {data.attrs.get('survey_id', '')}".rstrip()
    data.attrs["title"] = marked(title, data)
    data.attrs.setdefault("history", "written by gpr20_analysis")
    return data


def encoding(data: xr.Dataset) -> Dict[str, Dict[str, Any]]:
    """Return the encoding: coordinates have no missing values."""
    return {str(name): {"_FillValue": None} for name in data.dims if name in data.coords}
