"""RecursiveArma: the same numbers as the command, whatever way the samples come."""

import copy
import pickle
import threading

import numpy as np
import pytest
import rarma
from signals import FS, MODES, vibration

ORDERS = [(2, 1), (2, 2), (4, 3), (6, 6), (8, 7), (8, 8), (5, 4), (10, 9), (4, 6), (3, 0), (0, 2)]


@pytest.fixture(scope="module")
def x():
    return vibration(MODES, 6000)


def same(one, two):
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, two))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("method", ["rpem", "rplr", "gradient"])
def test_bit_identical_with_the_command(command, tmp_path, x, order, method):
    (tmp_path / "x.f64").write_bytes(x.astype("<f8").tobytes())
    found = command.json(
        "identify", tmp_path / "x.f64", "--fs", FS, "--order", "{},{}".format(*order),
        "--method", method, "--forgetting", 0.9995, "--random-walk", 1e-9,
        "--band", "full", "--detrend", "none",
    )  # fmt: skip
    settings = {"forgetting": 0.9995, "random_walk": 1e-9, "method": method}
    model = rarma.RecursiveArma(*order, FS, **settings)
    model.push(x)
    model.finish_start()
    assert model.a.tolist() == found["a"] and model.c.tolist() == found["c"]
    modes = model.modes()
    if method == "gradient":
        # There the command states the bound of the model, for the covariance is the start's.
        keep = ("f", "zeta")
        modes = [{name: mode[name] for name in keep} for mode in modes]
        found["modes"] = [{name: mode[name] for name in keep} for mode in found["modes"]]
    assert modes == found["modes"]


@pytest.mark.parametrize("order", ORDERS)
def test_pieces_and_layouts_give_the_same_as_the_whole(x, order):
    whole = rarma.RecursiveArma(*order, FS).push(x)
    assert whole.f_hz.shape == (len(x), (order[0] + 1) // 2)
    cuts = np.sort(np.random.default_rng(2).integers(1, len(x), 9))
    wide = np.zeros((len(x), 3))
    wide[:, 1] = x
    backwards = x[::-1].copy()
    for layout in (x, wide[:, 1], backwards[::-1]):
        model = rarma.RecursiveArma(*order, FS)
        parts = [model.push(part) for part in np.split(layout, cuts) if len(part)]
        assert same([np.concatenate(column) for column in zip(*parts)], whole)
        assert model.samples == len(x)


def test_single_precision_samples_are_taken_as_they_are(x):
    single = x.astype(np.float32)
    model, other = (rarma.RecursiveArma(4, 3, FS) for _ in range(2))
    assert same(model.push(single), other.push(single.astype(float)))
    assert same(model.push(single[::3]), other.push(single[::3].astype(float)))


@pytest.mark.parametrize("order", [(2, 1), (8, 7), (5, 4)])
@pytest.mark.parametrize("cut", [1, 300, 450, 700, 1000, 4000])
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_a_pickle_goes_on_as_if_nothing_had_been(x, order, cut, protocol):
    model = rarma.RecursiveArma(*order, FS, forgetting=0.999, random_walk=1e-9)
    model.push(x[:cut])
    again = pickle.loads(pickle.dumps(model, protocol))
    assert repr(again) == repr(model)
    assert same(again.push(x[cut:], every=7), model.push(x[cut:], every=7))
    assert np.array_equal(again.covariance, model.covariance)
    assert pickle.dumps(again) == pickle.dumps(model)


def test_a_copy_is_a_model_of_its_own(x):
    model = rarma.RecursiveArma(4, 3, FS)
    model.push(x)
    other = copy.deepcopy(model)
    other.push(x)
    assert other.samples == 2 * model.samples
    assert not np.array_equal(other.a, model.a)


def test_what_is_no_state_is_refused_and_changes_nothing(x):
    model = rarma.RecursiveArma(4, 3, FS)
    model.push(x)
    before, state = repr(model), model.__getstate__()
    broken = bytearray(state)
    broken[len(state) // 2] ^= 1
    other = rarma.RecursiveArma(6, 5, FS).__getstate__()
    for wrong in (b"", state[:-1], state[:200], bytes(broken), other, b"x" * len(state)):
        with pytest.raises(ValueError, match=f"{len(wrong)} bytes are not the state"):
            model.__setstate__(wrong)
    assert repr(model) == before and model.__getstate__() == state


def test_rows_come_at_every_so_many_samples_whatever_the_pieces(x):
    whole = rarma.RecursiveArma(4, 3, FS).push(x, every=50)
    model = rarma.RecursiveArma(4, 3, FS)
    parts = [model.push(part, every=50) for part in (x[:1234], x[1234:1240], x[1240:])]
    assert same([np.concatenate(column) for column in zip(*parts)], whole)
    # Roots that are sought at a row are those that are followed from sample to sample.
    all_of_them = rarma.RecursiveArma(4, 3, FS).push(x)
    each = rarma.Readings(*(column[49::50] for column in all_of_them))
    assert whole.f_hz.shape == (len(x) // 50, 2)
    assert np.array_equal(np.isnan(whole.f_hz), np.isnan(each.f_hz))
    model_is_there = ~np.isnan(whole.f_hz)
    for name in ("f_hz", "zeta"):
        off = np.abs(getattr(whole, name) - getattr(each, name)) / getattr(each, "sd_" + name)
        assert off[model_is_there].max() < 1e-4


@pytest.mark.parametrize("seed", range(10))
def test_the_truth_lies_within_the_stated_deviations(seed):
    model = rarma.RecursiveArma(8, 7, FS)
    readings = model.push(vibration(MODES, 16_000, seed), every=16_000)
    true_f, true_zeta = np.array(MODES).T
    # Of 80 values none lies 4.5 deviations off by chance (5e-4 of all runs).
    assert np.all(np.abs(readings.f_hz[-1] - true_f) < 4.5 * readings.sd_f_hz[-1])
    assert np.all(np.abs(readings.zeta[-1] - true_zeta) < 4.5 * readings.sd_zeta[-1])
    # And they are not so wide that they mean nothing.
    assert np.all(readings.sd_f_hz[-1] < 5.0) and np.all(readings.sd_zeta[-1] < 0.004)


def test_there_is_no_mode_before_there_is_a_model(x):
    model = rarma.RecursiveArma(4, 3, FS)
    readings = model.push(x[:300])
    assert not model.ready and model.modes() == []
    assert all(np.isnan(column).all() for column in readings)
    model.push(x[300:])
    assert model.ready and len(model.modes()) == 2


def test_the_covariance_is_one(x):
    model = rarma.RecursiveArma(8, 7, FS, forgetting=0.999)
    model.push(x)
    covariance = model.covariance
    assert covariance.shape == (15, 15)
    assert np.allclose(covariance, covariance.T) and np.linalg.eigvalsh(covariance)[0] > 0


def test_a_call_on_an_object_at_work_is_refused_and_changes_nothing():
    x = np.random.default_rng(1).standard_normal(3_000_000)
    model, alone = (rarma.RecursiveArma(8, 7, 48_000.0) for _ in range(2))
    work = threading.Thread(target=model.push, args=(x,), kwargs={"every": len(x)})
    work.start()
    refused = []
    while work.is_alive() and not refused:
        try:
            model.modes()
        except RuntimeError as why:
            refused.append(str(why))
    work.join()
    assert len(refused) == 1 and "orrowed" in refused[0], refused
    alone.push(x, every=len(x))
    assert np.array_equal(model.a, alone.a)


def test_other_threads_run_meanwhile():
    model = rarma.RecursiveArma(8, 7, FS)
    long = np.tile(vibration(MODES, 4000), 100)
    turns, over = 0, threading.Event()

    def count():
        nonlocal turns
        while not over.is_set():
            turns += 1

    other = threading.Thread(target=count)
    other.start()
    before = turns
    model.push(long)
    during = turns - before
    over.set()
    other.join()
    # Held back, the other thread gets no turn at all between the two readings.
    assert during > 1000


ONE = (2, 1, FS)


@pytest.mark.parametrize(
    ("error", "says", "call"),
    [
        (TypeError, "p: 2.5 is no whole number", lambda: rarma.RecursiveArma(2.5, 1, FS)),
        (ValueError, "p: -1: must lie between 0 and 30", lambda: rarma.RecursiveArma(-1, 1, FS)),
        (ValueError, "q: 31: must lie between 0 and 30", lambda: rarma.RecursiveArma(2, 31, FS)),
        (ValueError, "p: 1000000000000000000000: must", lambda: rarma.RecursiveArma(10**21, 1, FS)),
        (ValueError, "p, q: 0, 0: nothing to estimate", lambda: rarma.RecursiveArma(0, 0, FS)),
        (ValueError, "sample_rate_hz: 0: must lie", lambda: rarma.RecursiveArma(2, 1, 0.0)),
        (ValueError, "sample_rate_hz: -8000: must", lambda: rarma.RecursiveArma(2, 1, -FS)),
        (ValueError, "sample_rate_hz: NaN: must", lambda: rarma.RecursiveArma(2, 1, np.nan)),
        (ValueError, "method: 'x' is none|method: \"x\" is none", lambda: rarma.RecursiveArma(*ONE, method="x")),
        (ValueError, "forgetting: 2: must", lambda: rarma.RecursiveArma(*ONE, forgetting=2.0)),
        (ValueError, "random_walk: -1: must", lambda: rarma.RecursiveArma(*ONE, random_walk=-1.0)),
        (ValueError, "forgetting: NaN", lambda: rarma.RecursiveArma(*ONE, forgetting=np.nan)),
        (ValueError, "start_samples: 401: must", lambda: rarma.RecursiveArma(*ONE, start_samples=401)),
        (ValueError, "every: 0: must be 1 or more", lambda: rarma.RecursiveArma(*ONE).push(np.ones(9), every=0)),
        (ValueError, r"x\[3\]: 1e15: must stay below", lambda: rarma.RecursiveArma(*ONE).push(np.array([0, 1, 2, 1e15]))),
    ],
)  # fmt: skip
def test_bad_settings_say_what_and_where(error, says, call):
    with pytest.raises(error, match=says):
        call()


def test_orders_and_rates_may_be_numpys():
    model = rarma.RecursiveArma(np.int64(4), np.int32(3), np.float32(FS))
    assert (model.p, model.q, model.sample_rate_hz) == (4, 3, FS)
