"""What functions return that return several things."""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np
import numpy.typing as npt


class Readings(NamedTuple):
    """Modes at every sample, each array of shape (rows, modes); NaN where there is no mode."""

    f_hz: npt.NDArray[np.float64]
    """Undamped natural frequency, Hz."""
    zeta: npt.NDArray[np.float64]
    """Damping ratio."""
    sd_f_hz: npt.NDArray[np.float64]
    """Standard deviation of f_hz, Hz."""
    sd_zeta: npt.NDArray[np.float64]
    """Standard deviation of zeta."""


class Recording(NamedTuple):
    """One channel of a file."""

    samples: npt.NDArray[np.float64]
    """Samples, shape (n,); whole numbers are scaled to ±1."""
    sample_rate_hz: float
    """Sampling rate, Hz."""
    full_scale: Optional[float]
    """Largest value the format can hold: 1 for whole numbers, None where there is no limit."""
    channels: int
    """Channels in the file."""
    notices: List[str]
    """What is odd about it, a sentence each."""


class Simulation(NamedTuple):
    """A virtual cut."""

    samples: npt.NDArray[np.float64]
    """Samples as parts of full scale, shape (n,)."""
    sample_rate_hz: float
    """Sampling rate, Hz."""
    truth: Dict[str, Any]
    """What is true of it, as the JSON of ``rarma simulate --truth``."""
    clipped: int
    """Samples at the end of the range."""
