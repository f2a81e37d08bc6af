"""The half of the package that is written in Rust."""

import os
from typing import Any, Dict, Final, List, Literal, Mapping, Optional, Sequence, Tuple, Union, final

import numpy as np
import numpy.typing as npt

from ._results import Readings, Recording, Simulation

__all__ = [
    "Monitor",
    "RecursiveArma",
    "RecursiveChannels",
    "decode",
    "identify",
    "identify_channels",
    "lobes",
    "monitor_of_state",
    "order",
    "psd",
    "read",
    "scenarios",
    "simulate",
]

_Signal = Union[npt.NDArray[np.float64], npt.NDArray[np.float32]]
_Path = Union[str, os.PathLike[str]]
_Band = Union[Tuple[float, float], Literal["full"]]
_Method = Literal[
    "pem",
    "ml",
    "rpem",
    "rplr",
    "gradient",
    "riv",
    "iv",
    "burg",
    "yule-walker",
    "least-squares",
    "lattice",
    "esprit",
    "tones",
]

@final
class RecursiveArma:
    def __new__(
        cls,
        p: int,
        q: int,
        sample_rate_hz: float,
        *,
        forgetting: float = 1.0,
        random_walk: float = 0.0,
        method: Literal["rpem", "rplr", "gradient"] = "rpem",
        start_samples: int = 400,
    ) -> "RecursiveArma": ...
    def push(self, x: _Signal, *, every: int = 1) -> Readings: ...
    def modes(self) -> List[Dict[str, Optional[float]]]: ...
    def finish_start(self) -> None: ...
    @property
    def p(self) -> int: ...
    @property
    def q(self) -> int: ...
    @property
    def sample_rate_hz(self) -> float: ...
    @property
    def samples(self) -> int: ...
    @property
    def ready(self) -> bool: ...
    @property
    def a(self) -> npt.NDArray[np.float64]: ...
    @property
    def c(self) -> npt.NDArray[np.float64]: ...
    @property
    def sigma2(self) -> float: ...
    @property
    def covariance(self) -> npt.NDArray[np.float64]: ...
    def __getnewargs_ex__(self) -> Tuple[Tuple[int, int, float], Dict[str, Any]]: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

@final
class RecursiveChannels:
    def __new__(
        cls,
        p: int,
        q: int,
        channels: int,
        sample_rate_hz: float,
        *,
        forgetting: float = 1.0,
        random_walk: float = 0.0,
        weights: Literal["own", "joint"] = "own",
        start_samples: int = 400,
    ) -> "RecursiveChannels": ...
    def push(self, x: _Signal, *, every: int = 1) -> Readings: ...
    def modes(self) -> List[Dict[str, Any]]: ...
    def finish_start(self) -> None: ...
    @property
    def p(self) -> int: ...
    @property
    def q(self) -> int: ...
    @property
    def channels(self) -> int: ...
    @property
    def sample_rate_hz(self) -> float: ...
    @property
    def samples(self) -> int: ...
    @property
    def ready(self) -> bool: ...
    @property
    def a(self) -> npt.NDArray[np.float64]: ...
    @property
    def c(self) -> npt.NDArray[np.float64]: ...
    @property
    def innovation_covariance(self) -> npt.NDArray[np.float64]: ...
    def __getnewargs_ex__(self) -> Tuple[Tuple[int, int, int, float], Dict[str, Any]]: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

@final
class Monitor:
    def __new__(
        cls,
        sample_rate_hz: float,
        *,
        order: Tuple[int, int] = (8, 7),
        rpm: Optional[float] = None,
        teeth: Optional[int] = None,
        band_hz: Optional[Tuple[float, float]] = None,
        threshold: float = 0.01,
        idle_s: Optional[Tuple[float, float]] = None,
        every_s: float = 0.01,
        aliased: bool = False,
        structure: Optional[_Path] = None,
        full_scale: Optional[float] = None,
        set: Optional[Mapping[str, float]] = None,
        reach_percent: Optional[Tuple[float, float]] = None,
        power: Optional[float] = None,
        same_feed: bool = False,
        swing_percent: Optional[float] = None,
        swing_acceleration_rad_s2: Optional[float] = None,
        swing_hz: Optional[float] = None,
    ) -> "Monitor": ...
    def push(self, x: _Signal) -> List[Dict[str, Any]]: ...
    def missing(self, samples: int) -> None: ...
    def tell_speed(self, rpm: float) -> None: ...
    def summary(self) -> Dict[str, Any]: ...
    @property
    def missing_for_advice(self) -> List[str]: ...
    @property
    def sample_rate_hz(self) -> float: ...
    def __copy__(self) -> "Monitor": ...
    def __deepcopy__(self, _memo: Any) -> "Monitor": ...
    def __reduce__(self) -> Tuple[Any, Tuple[bytes]]: ...

def monitor_of_state(state: bytes) -> Monitor: ...
def identify(
    x: _Signal,
    sample_rate_hz: float,
    order: Tuple[int, int],
    *,
    method: _Method = "pem",
    band_hz: Optional[_Band] = None,
    detrend: Literal["none", "mean", "linear"] = "mean",
    forgetting: float = 1.0,
    random_walk: float = 0.0,
) -> Dict[str, Any]: ...
def identify_channels(
    x: _Signal,
    sample_rate_hz: float,
    order: int,
    *,
    references: Optional[Sequence[int]] = None,
    rows: int = 20,
    stretches: int = 100,
    band_hz: Optional[_Band] = None,
    detrend: Literal["none", "mean", "linear"] = "mean",
) -> Dict[str, Any]: ...
def order(
    x: _Signal,
    sample_rate_hz: float,
    *,
    max_p: int = 10,
    band_hz: Optional[_Band] = None,
    criterion: Literal["aic", "aicc", "bic", "fpe"] = "bic",
) -> Dict[str, Any]: ...
def psd(
    x: _Signal,
    sample_rate_hz: float,
    *,
    method: Literal["welch", "periodogram", "ar", "arma"] = "welch",
    order: Optional[Tuple[int, int]] = None,
    band_hz: Optional[_Band] = None,
    at_hz: Optional[float] = None,
) -> Dict[str, Any]: ...
def read(
    path: _Path, *, channel: int = 0, sample_rate_hz: Optional[float] = None
) -> Recording: ...
def decode(data: bytes) -> List[Dict[str, Any]]: ...
def scenarios() -> Dict[str, str]: ...
def simulate(scenario: _Path, *, seed: Optional[int] = None) -> Simulation: ...
def lobes(
    scenario: _Path,
    *,
    rpm: Optional[Tuple[float, float]] = None,
    speeds: int = 121,
    max_depth_mm: Optional[float] = None,
) -> Dict[str, Any]: ...
