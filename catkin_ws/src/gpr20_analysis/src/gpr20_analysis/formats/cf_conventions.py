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
ANCILLARY = (dataset.QUALITY, dataset.HEIGHT, dataset.TIMESTAMP)


def with_conventions(stored: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with the attributes of the conventions; values are unchanged.

    Args:
        stored: Dataset without complex numbers.
    """
    data = stored.copy()
    for name in data.variables:
        added = _added(data, str(name))
        own = {**added, **data[name].attrs}
        if "flag_masks" in own:
            own["flag_masks"] = np.asarray(own["flag_masks"], data[name].dtype)
        data[name].attrs = own
    return data.assign_attrs({**_described(data), **data.attrs})


def without_conventions(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset, complex again, without what `with_conventions` has added."""
    for name in data.variables:
        own = data[name].attrs
        for key, value in _added(data, str(name)).items():
            if str(own.get(key)) == value:
                del own[key]
        if "flag_masks" in own:
            own["flag_masks"] = np.asarray(own["flag_masks"]).tolist()
    for key, value in _described(data).items():
        if data.attrs.get(key) == value:
            del data.attrs[key]
    return dataset.described(data) if dataset.QUALITY in data else data


def _added(data: xr.Dataset, name: str) -> Dict[str, str]:
    is_image = dataset.DEPTH in data.dims
    added = {"long_name": name.replace("_", " ")}
    if name in AXES and is_image:
        added["axis"] = AXES[name]
    if name in PLANE and is_image:
        added["standard_name"] = PLANE[name]
    if name == dataset.HEIGHT:
        added["positive"] = "up"
    if name in STANDARD_NAMES:
        added["standard_name"] = STANDARD_NAMES[name]
    beside = [one for one in ANCILLARY if one in data]
    if beside and set(dataset.SAMPLE_DIMS) < set(data[name].dims):
        added["ancillary_variables"] = " ".join(beside)
    return added


def _described(data: xr.Dataset) -> Dict[str, str]:
    title = f"GPR-20 survey {data.attrs.get('survey_id', '')}".rstrip()
    return {
        "Conventions": CONVENTIONS,
        "title": marked(title, data),
        "history": "written by gpr20_analysis",
    }


def encoding(data: xr.Dataset) -> Dict[str, Dict[str, Any]]:
    """Return the encoding: coordinates have no missing values."""
    return {str(name): {"_FillValue": None} for name in data.dims if name in data.coords}
