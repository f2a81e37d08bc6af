"""Listens to machine tools: the operational damping of a cut, at every sample.

Signals are numpy arrays of float64 or float32 with one dimension. Everything is in SI units, the
unit is in the name: ``_hz``, ``_s``; spindle speeds in 1/min are ``rpm``. Damping ratios are
ratios (0.02 is 2 %). ``sd_`` and ``_sd`` are standard deviations.
"""

from importlib.metadata import version as _version

from ._rarma import (
    Monitor,
    RecursiveArma,
    RecursiveChannels,
    decode,
    identify,
    identify_channels,
    lobes,
    order,
    psd,
    read,
    scenarios,
    simulate,
)
from ._results import Readings, Recording, Simulation
from .advice import advise
from .tables import to_numpy, to_pandas

__version__ = _version("rarma")

__all__ = [
    "Monitor",
    "Readings",
    "Recording",
    "RecursiveArma",
    "RecursiveChannels",
    "Simulation",
    "advise",
    "decode",
    "identify",
    "identify_channels",
    "lobes",
    "order",
    "psd",
    "read",
    "scenarios",
    "simulate",
    "to_numpy",
    "to_pandas",
]
