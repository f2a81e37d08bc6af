"""Records and readings as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._results import Readings

if TYPE_CHECKING:
    import pandas

_MODE = [
    ("f", "f8"),
    ("f_sd", "f8"),
    ("zeta", "f8"),
    ("zeta_sd", "f8"),
    ("amplitude", "f8"),
    ("label", "U16"),
    ("harmonic", "f8"),
    ("origin", "U16"),
]
_RECORD = [
    ("t", "f8"),
    ("state", "U8"),
    ("reason", "U24"),
    ("rpm", "f8"),
    ("mode", "i8"),
    *_MODE,
]


def _rows(records: Sequence[Dict[str, Any]]) -> List[tuple]:
    def number(x: Optional[float]) -> float:
        return float("nan") if x is None else x

    nothing: Dict[str, Any] = {"label": "", "origin": ""}
    rows = []
    for k, record in enumerate(records):
        try:
            head = (record["t"], record["state"], record["reason"])
            rpm = number(record["spindle"]["rpm"])
            modes = list(enumerate(record["modes"])) or [(-1, nothing)]
        except (KeyError, TypeError) as why:
            raise ValueError(
                f"records[{k}]: no record of a monitor: {why!r} (pass what Monitor.push returned)"
            ) from None
        for number_of_mode, mode in modes:
            values = (
                mode.get(name) or "" if kind[0] == "U" else number(mode.get(name))
                for name, kind in _MODE
            )
            rows.append((*head, rpm, number_of_mode, *values))
    return rows


def to_numpy(records: Sequence[Dict[str, Any]]) -> npt.NDArray[np.void]:
    """Records of a monitor as a structured array, a row for each mode of each record.

    Fields: t (s), state, reason, rpm (1/min, NaN where it is not
    known), mode (0 for the lowest; -1 in the one row of a record without modes), f and f_sd (Hz),
    zeta and zeta_sd (ratios), amplitude (units of the signal), label, harmonic (NaN for none) and
    origin. What else a record holds is not in the table.
    """
    return np.array(_rows(records), dtype=_RECORD)


def to_pandas(
    table: Union[Readings, Sequence[Dict[str, Any]]],
    sample_rate_hz: Optional[float] = None,
    every: int = 1,
) -> "pandas.DataFrame":
    """Records of a monitor, or readings of a model, as a DataFrame; pandas must be installed.

    Of records a row for each mode of each record, with the columns of `to_numpy`. Of readings a
    row for each mode of each row: sample (counted from 0), t (s, if ``sample_rate_hz`` is given),
    mode, f_hz, zeta, sd_f_hz, sd_zeta; ``every`` is that of the push, and the first sample is
    that of the push.
    """
    import pandas

    if not isinstance(table, Readings):
        return pandas.DataFrame(to_numpy(table))
    rows, modes = table.f_hz.shape
    sample = np.repeat((np.arange(rows) + 1) * every - 1, modes)
    columns: Dict[str, Any] = {"sample": sample}
    if sample_rate_hz is not None:
        columns["t"] = sample / sample_rate_hz
    columns["mode"] = np.tile(np.arange(modes), rows)
    columns.update((name, values.ravel()) for name, values in table._asdict().items())
    return pandas.DataFrame(columns)
