"""Signals that cannot be taken: every function says what is wrong, where, and what to do."""

import numpy as np
import pytest
import rarma
from signals import FS, MODES, vibration

GOOD = np.linspace(-1.0, 1.0, 64)
UNALIGNED = np.frombuffer(b"\0" + GOOD.tobytes(), dtype="u1")[1:].view("f8")
TAKERS = {
    "RecursiveArma.push": lambda x: rarma.RecursiveArma(2, 1, FS).push(x),
    "Monitor.push": lambda x: rarma.Monitor(FS).push(x),
    "advise": lambda x: rarma.advise(x, FS),
    "identify": lambda x: rarma.identify(x, FS, (2, 1)),
    "order": lambda x: rarma.order(x, FS),
    "psd": lambda x: rarma.psd(x, FS),
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize(
    ("error", "says", "x"),
    [
        (TypeError, "x: list is no numpy array [(]pass numpy.asarray", [1.0, 2.0]),
        (TypeError, "x: NoneType is no numpy array", None),
        (TypeError, "x: str is no numpy array", "cut.wav"),
        (TypeError, "x: dtype int16 .* such as x / 32768.0 for 16 bit", np.zeros(9, "i2")),
        (TypeError, "x: dtype uint8 ", np.zeros(9, "u1")),
        (TypeError, "x: dtype bool ", np.zeros(9, bool)),
        (TypeError, "x: dtype complex128 ", np.zeros(9, complex)),
        (TypeError, "x: dtype float16 .*pass x.astype[(]float[)]", np.zeros(9, "f2")),
        (TypeError, "x: dtype object ", np.array([1.0, None])),
        (TypeError, "x: dtype >f8 .* byte order", GOOD.astype(">f8")),
        (TypeError, "x: dtype <U3 ", np.array(["1.0"])),
        (ValueError, r"x: shape \(64, 1\) .* x\[:, 0\]", GOOD[:, None]),
        (ValueError, r"x: shape \(\) ", np.array(1.0)),
        (ValueError, r"x: shape \(0,\) holds no sample", np.zeros(0)),
        (ValueError, "x: its samples do not lie at multiples of their size", UNALIGNED),
        (ValueError, r"x\[2\]: NaN is no sample", np.array([1.0, 2.0, np.nan, 3.0])),
        (ValueError, r"x\[1\]: -inf is no sample", np.array([1.0, -np.inf], "f4")),
        (ValueError, r"x\[3\]: NaN", np.array([1, 9, 2, 9, 3, 9, np.nan, 9.0])[::2]),
    ],
)
def test_what_is_no_signal_is_refused(taker, error, says, x):
    with pytest.raises(error, match=says):
        TAKERS[taker](x)


@pytest.mark.parametrize("taker", ["identify", "order", "psd"])
def test_a_signal_without_vibration_is_refused(taker):
    with pytest.raises(ValueError, match="x: .*(constant|the same|every sample)"):
        TAKERS[taker](np.ones(4000))


def test_what_is_refused_has_changed_nothing():
    x = vibration(MODES[:2], 3000)
    one, two = (rarma.RecursiveArma(4, 3, FS) for _ in range(2))
    one.push(x)
    two.push(x)
    wrong = x.copy()
    wrong[-1] = np.nan
    with pytest.raises(ValueError, match=r"x\[2999\]"):
        one.push(wrong)
    assert one.__getstate__() == two.__getstate__()
