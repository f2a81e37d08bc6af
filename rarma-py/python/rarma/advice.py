"""Which speed to turn instead."""

from __future__ import annotations

from typing import Any, Dict

import numpy as np

from ._rarma import Monitor


def advise(x: np.ndarray, sample_rate_hz: float, **options: Any) -> Dict[str, Any]:
    """Listens to a whole cut, then says which speed to turn instead: ``rarma advise``.

    Parameters
    ----------
    x : numpy array of float64 or float32, shape (n,)
        Samples, in any unit.
    sample_rate_hz : float
        Sampling rate, Hz.
    **options
        Those of `Monitor`. Without ``rpm`` and ``teeth`` there is no advice.

    Returns
    -------
    dict
        alarms (list of dicts: on and off in s, f in Hz, zeta, zeta_median and zeta_deviation, and
        advice with the speeds to turn in 1/min, the chance that the cut is stable there, and what
        helps where there is none) and missing, a list of what would have to be told: "speed", "teeth".
    """
    monitor = Monitor(sample_rate_hz, **options)
    monitor.push(x)
    return {"alarms": monitor.summary()["alarms"], "missing": monitor.missing_for_advice}
