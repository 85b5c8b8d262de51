"""The local maxima of an image above its noise, and those of them that are one candidate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence

import numpy as np
from scipy.ndimage import maximum_filter

from gpr20_analysis.candidates.rating import Rating

# Peaks whose neighbors are looked up together; each may have many.
PEAKS_AT_ONCE = 1000


@dataclass(frozen=True)
class Peaks:
    """Local maxima, the brightest first.

    Attributes:
        place: Indices (peak, 4): polarization, depth, y, x.
        level: Magnitudes above noise.
    """

    place: np.ndarray
    level: np.ndarray


@dataclass(frozen=True)
class Groups:
    """Peaks of one place each, the group with the brightest first.

    Attributes:
        members: Indices of the peaks of each group, the brightest first.
        first: Indices (group, 4) of the brightest voxel above its noise.
        level: Its magnitude above noise.
        top: Indices (group, 4) of the voxel of greatest magnitude. The noise varies over the image,
            so it need not be the one that is furthest above its noise.
    """

    members: List[np.ndarray]
    first: np.ndarray
    level: np.ndarray
    top: np.ndarray


def find_peaks(rating: Rating, false_alarm_rate: float) -> Peaks:
    """Return the maxima that noise exceeds anywhere with a probability.

    Args:
        rating: The brightness of the voxels.
        false_alarm_rate: The probability, 0 to 1.
    """
    threshold = rating.threshold(false_alarm_rate)
    places, levels = [], []
    for turn in range(rating.polarizations):
        level, magnitude = rating.level(turn), rating.magnitude(turn)
        highest = maximum_filter(magnitude, size=3, mode="nearest")
        chosen = np.argwhere((magnitude == highest) & (magnitude > 0.0) & (level >= threshold))
        places.append(np.insert(chosen, 0, turn, axis=1))
        levels.append(level[tuple(chosen.T)])
    place, level = np.concatenate(places), np.concatenate(levels)
    order = np.argsort(-level, kind="stable")
    return Peaks(place[order], level[order])


def grouped(peaks: Peaks, rating: Rating, axes: Sequence[np.ndarray]) -> Groups:
    """Return the peaks of each place: those within the resolution of a brighter one.

    Args:
        peaks: The peaks.
        rating: The brightness of the voxels.
        axes: Depths, positions along Y, positions along X [m].
    """
    where_m = [axis[peaks.place[:, number]] for number, axis in enumerate(axes, 1)]
    members = _groups(np.stack(where_m, axis=1) / rating.resolution_m)
    magnitude = rating.magnitudes_at(peaks.place)
    first = np.array([own[0] for own in members], dtype=int)
    top = np.array([own[np.argmax(magnitude[own])] for own in members], dtype=int)
    return Groups(members, peaks.place[first], peaks.level[first], peaks.place[top])


def _groups(place: np.ndarray) -> List[np.ndarray]:
    """Return the points within 1 of the first point that is in no group yet, in order."""
    if len(place) == 0:
        return []
    from scipy.spatial import cKDTree  # its import takes 0.1 s

    tree = cKDTree(place)
    left = np.ones(len(place), dtype=bool)
    groups = []
    for start in range(0, len(place), PEAKS_AT_ONCE):
        ahead = start + np.flatnonzero(left[start : start + PEAKS_AT_ONCE])
        # A little further, because the distance of the tree is rounded in another way.
        around = tree.query_ball_point(place[ahead], 1.0 + 1e-9)
        for first, near in zip(ahead.tolist(), around):
            if not left[first]:
                continue
            own = np.sort(near)
            own = own[left[own]]
            own = own[np.sum((place[own] - place[first]) ** 2, axis=1) <= 1.0]
            left[own] = False
            groups.append(own)
    return groups
