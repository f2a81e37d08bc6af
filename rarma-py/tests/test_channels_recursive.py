"""RecursiveChannels: one A for all channels, whatever way the samples come."""

import copy
import pickle
import threading

import numpy as np
import pytest
import rarma
from signals import FS, MODES, vibration

TWO = MODES[:2]


@pytest.fixture(scope="module")
def x():
    """Each sensor in the node of a mode but the third, all with noise."""
    noise = np.random.default_rng(5).standard_normal((6000, 3))
    modes = [vibration([mode], 6000, seed) for seed, mode in enumerate(TWO)]
    modes = [mode / mode.std() for mode in modes]
    return np.column_stack([modes[0], 2.0 * modes[1], modes[0] - modes[1]]) + 0.1 * noise


def same(one, two):
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, two))


def test_one_channel_is_the_model_of_one_channel(x):
    one = rarma.RecursiveArma(4, 4, FS, forgetting=0.9995)
    other = rarma.RecursiveChannels(4, 4, 1, FS, forgetting=0.9995)
    a, b = one.push(x[:, 2]), other.push(x[:, 2:])
    assert np.allclose(other.a, one.a, rtol=1e-10) and np.allclose(other.c, one.c, rtol=1e-10)
    assert np.allclose(other.innovation_covariance, one.sigma2, rtol=1e-10)
    # The roots are followed by a sweep a sample, each from where it was found.
    for left, right, sd in zip(a, b, (a.sd_f_hz, a.sd_zeta, a.sd_f_hz, a.sd_zeta)):
        assert np.all(np.abs(left - right)[1400:] < 0.01 * sd[1400:])


@pytest.mark.parametrize("weights", ["own", "joint"])
def test_both_modes_are_read_with_their_shapes(x, weights):
    model = rarma.RecursiveChannels(4, 4, 3, FS, weights=weights)
    readings = model.push(x, every=len(x))
    assert readings.f_hz.shape == (1, 2)
    true_f, true_zeta = np.array(TWO).T
    assert np.all(np.abs(readings.f_hz[-1] - true_f) < 4.5 * readings.sd_f_hz[-1])
    assert np.all(np.abs(readings.zeta[-1] - true_zeta) < 4.5 * readings.sd_zeta[-1])
    assert np.all(readings.sd_f_hz[-1] < 5.0) and np.all(readings.sd_zeta[-1] < 0.006)
    modes = model.modes()
    for mode, f, zeta in zip(modes, readings.f_hz[-1], readings.zeta[-1]):
        assert abs(mode["f"] - f) < 1e-3 and abs(mode["zeta"] - zeta) < 1e-6
    shapes = np.array([[[part["re"], part["im"]] for part in mode["shape"]] for mode in modes])
    # Of the first mode the second sensor hears nothing, of the second the first.
    for shape, seen in zip(shapes, ([1, 0, 1], [0, 1, -0.5])):
        assert np.abs(np.hypot(*shape.T) - np.abs(seen)).max() < 0.15
    amplitudes = [[part["amplitude"] for part in mode["shape"]] for mode in modes]
    assert np.allclose(np.array(amplitudes), [[1, 0, 1], [0, 2, 1]], atol=0.25)
    assert model.innovation_covariance.shape == (3, 3) and model.c.shape == (3, 4)


def test_pieces_and_layouts_give_the_same_as_the_whole(x):
    whole = rarma.RecursiveChannels(4, 4, 3, FS).push(x, every=3)
    cuts = np.sort(np.random.default_rng(2).integers(1, len(x), 9))
    for layout in (x, np.asfortranarray(x), np.repeat(x, 2, axis=1)[:, ::2], x[::-1].copy()[::-1]):
        model = rarma.RecursiveChannels(4, 4, 3, FS)
        parts = [model.push(part, every=3) for part in np.split(layout, cuts) if len(part)]
        joined = [np.concatenate(column) for column in zip(*parts)]
        # Followed from row to row, or sought at once: the same but for the last digits.
        assert all(np.allclose(a, b, rtol=1e-9, equal_nan=True) for a, b in zip(joined, whole))
        assert model.samples == len(x)
    single = x.astype(np.float32)
    one, two = (rarma.RecursiveChannels(4, 4, 3, FS) for _ in range(2))
    assert same(one.push(single), two.push(single.astype(float)))


@pytest.mark.parametrize("weights", ["own", "joint"])
@pytest.mark.parametrize("cut", [1, 300, 400, 450, 4000])
def test_a_pickle_goes_on_as_if_nothing_had_been(x, weights, cut):
    model = rarma.RecursiveChannels(4, 4, 3, FS, forgetting=0.999, weights=weights)
    model.push(x[:cut])
    again = pickle.loads(pickle.dumps(model))
    assert repr(again) == repr(model)
    assert same(again.push(x[cut:], every=7), model.push(x[cut:], every=7))
    assert pickle.dumps(again) == pickle.dumps(model) and again.modes() == model.modes()
    other = copy.deepcopy(model)
    other.push(x)
    assert other.samples == model.samples + len(x) and not np.array_equal(other.a, model.a)


def test_what_is_no_state_is_refused_and_changes_nothing(x):
    model = rarma.RecursiveChannels(4, 4, 3, FS)
    model.push(x)
    before, state = repr(model), model.__getstate__()
    broken = bytearray(state)
    broken[len(state) // 2] ^= 1
    other = rarma.RecursiveChannels(4, 4, 2, FS).__getstate__()
    for wrong in (b"", state[:-1], bytes(broken), other, b"x" * len(state)):
        with pytest.raises(ValueError, match=f"{len(wrong)} bytes are not the state"):
            model.__setstate__(wrong)
    assert repr(model) == before and model.__getstate__() == state


def test_there_is_no_mode_before_there_is_a_model(x):
    model = rarma.RecursiveChannels(4, 4, 3, FS)
    readings = model.push(x[:300])
    assert not model.ready and model.modes() == []
    assert all(np.isnan(column).all() for column in readings)
    model.finish_start()
    assert model.ready and len(model.modes()) == 2


def test_other_threads_run_meanwhile(x):
    model = rarma.RecursiveChannels(8, 8, 3, FS)
    long = np.tile(x, (20, 1))
    turns, over = 0, threading.Event()

    def count():
        nonlocal turns
        while not over.is_set():
            turns += 1

    other = threading.Thread(target=count)
    other.start()
    before = turns
    model.push(long, every=1000)
    during = turns - before
    over.set()
    other.join()
    assert during > 1000


def bad(at, value):
    x = np.ones((9, 2))
    x[at] = value
    return x


MODEL = (2, 2, 2, FS)


@pytest.mark.parametrize(
    ("error", "says", "call"),
    [
        (TypeError, "channels: 2.5 is no whole number", lambda: rarma.RecursiveChannels(2, 1, 2.5, FS)),
        (ValueError, "channels: 0: must lie between 1 and 16", lambda: rarma.RecursiveChannels(2, 1, 0, FS)),
        (ValueError, "channels: 17: must lie", lambda: rarma.RecursiveChannels(2, 1, 17, FS)),
        (ValueError, "p: 31: must lie between 0 and 30", lambda: rarma.RecursiveChannels(31, 1, 2, FS)),
        (ValueError, "channels·q is 132, and must lie", lambda: rarma.RecursiveChannels(20, 14, 8, FS)),
        (ValueError, "channels·q is 0, and must lie", lambda: rarma.RecursiveChannels(0, 0, 2, FS)),
        (ValueError, "sample_rate_hz: 0: must lie", lambda: rarma.RecursiveChannels(2, 2, 2, 0.0)),
        (ValueError, "forgetting: 2: must", lambda: rarma.RecursiveChannels(*MODEL, forgetting=2.0)),
        (ValueError, 'weights: "x" is none of own, joint', lambda: rarma.RecursiveChannels(*MODEL, weights="x")),
        (ValueError, "start_samples: 10: must lie between 24 and 400", lambda: rarma.RecursiveChannels(*MODEL, start_samples=10)),
        (ValueError, "start_samples: 401: must", lambda: rarma.RecursiveChannels(*MODEL, start_samples=401)),
        (ValueError, "every: 0: must be 1 or more", lambda: rarma.RecursiveChannels(*MODEL).push(np.ones((9, 2)), every=0)),
        (ValueError, r"shape \(n, 3\) is not that of this model's channels, \(n, 2\)", lambda: rarma.RecursiveChannels(*MODEL).push(np.ones((9, 3)))),
        (ValueError, r"shape \(9,\) is not that of channels", lambda: rarma.RecursiveChannels(*MODEL).push(np.ones(9))),
        (ValueError, r"x\[:, 0\]: shape \(0,\) holds no sample", lambda: rarma.RecursiveChannels(*MODEL).push(np.ones((0, 2)))),
        (ValueError, r"x\[:, 1\]\[5\]: NaN is no sample", lambda: rarma.RecursiveChannels(*MODEL).push(bad((5, 1), np.nan))),
        (ValueError, r"x\[:, 1\]\[3\]: 1e15: must stay below", lambda: rarma.RecursiveChannels(*MODEL).push(bad((3, 1), 1e15))),
        (TypeError, "dtype int64 is neither", lambda: rarma.RecursiveChannels(*MODEL).push(np.ones((9, 2), int))),
        (TypeError, "list is no numpy array", lambda: rarma.RecursiveChannels(*MODEL).push([[1.0, 2.0]])),
    ],
)  # fmt: skip
def test_bad_settings_and_samples_say_what_and_where(error, says, call):
    with pytest.raises(error, match=says):
        call()


def test_a_bad_sample_changes_nothing(x):
    model = rarma.RecursiveChannels(4, 4, 3, FS)
    model.push(x[:1000])
    before = model.__getstate__()
    wrong = x[1000:].copy()
    wrong[70, 2] = np.inf
    with pytest.raises(ValueError, match=r"x\[:, 2\]\[70\]: inf is no sample"):
        model.push(wrong)
    assert model.__getstate__() == before
