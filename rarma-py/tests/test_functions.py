"""identify, order, psd, read, simulate, lobes: what the command says."""

import numpy as np
import pytest
import rarma
from signals import FS, MODES, vibration


@pytest.fixture(scope="module")
def x():
    return vibration(MODES[:2], 8000)


@pytest.fixture
def file(tmp_path, x):
    path = tmp_path / "x.f64"
    path.write_bytes(x.astype("<f8").tobytes())
    return path


def plain(record):
    """Arrays as lists, as JSON has them."""
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in record.items()}


@pytest.mark.parametrize(
    ("order", "options"),
    [
        ((4, 3), {}),
        ((4, 3), {"band_hz": "full"}),
        ((4, 4), {"band_hz": (400, 2000), "detrend": "linear"}),
        ((4, 2), {"method": "ml", "band_hz": (300, 1500)}),
        ((6, 0), {"method": "burg", "band_hz": "full"}),
        ((4, 3), {"method": "rpem", "forgetting": 0.999, "random_walk": 1e-8}),
        ((2, 2), {"method": "tones", "band_hz": "full"}),
        ((0, 0), {"band_hz": "full"}),
    ],
)
def test_identify(command, file, x, order, options):
    words = ["identify", file, "--fs", FS, "--order", "{},{}".format(*order)]
    for name, value in options.items():
        if isinstance(value, tuple):
            value = "{}:{}".format(*value)
        words += ["--" + name.replace("_hz", "").replace("_", "-"), value]
    found = rarma.identify(x, FS, order, **options)
    assert isinstance(found["a"], np.ndarray) and isinstance(found["c"], np.ndarray)
    assert plain(found) == command.json(*words)


def test_order(command, file, x):
    found = rarma.order(x, FS, max_p=5, criterion="aic")
    assert found == command.json("order", file, "--fs", FS, "--max", 5, "--criterion", "aic")
    assert found["choice"] == [4, 3] or found["choice"][0] >= 4


@pytest.mark.parametrize(
    ("words", "options"),
    [
        (["--method", "welch"], {}),
        (["--method", "periodogram", "--band", "full"], {"method": "periodogram", "band_hz": "full"}),
        (["--method", "arma", "--order", "4,3"], {"method": "arma", "order": (4, 3)}),
        (["--method", "ar", "--order", "9,0", "--at", "700"], {"method": "ar", "order": (9, 0), "at_hz": 700}),
    ],
)  # fmt: skip
def test_psd(command, file, x, words, options):
    found = rarma.psd(x, FS, **options)
    assert found["f"].shape == found["psd"].shape
    assert plain(found) == command.json("psd", file, "--fs", FS, *words)


def test_the_density_holds_the_power(x):
    density = rarma.psd(x, FS, method="periodogram", band_hz="full")
    power = density["psd"].sum() * (density["f"][1] - density["f"][0])
    assert power == pytest.approx(np.var(x), rel=1e-3)


@pytest.mark.parametrize("scenario", ["two-tooth-benchmark", "turning-980"])
def test_simulate_gives_what_the_file_of_the_command_holds(command, tmp_path, scenario):
    told = command.json("simulate", scenario, "--seed", 7, "--out", tmp_path / "cut.wav")
    found = rarma.simulate(scenario, seed=7)
    read = rarma.read(tmp_path / "cut.wav")
    assert np.array_equal(found.samples, read.samples)
    assert found.sample_rate_hz == read.sample_rate_hz and found.truth == told
    assert not np.array_equal(rarma.simulate(scenario, seed=8).samples, found.samples)


def test_lobes(command):
    words = ["--rpm", "8000:12000", "--speeds", 9, "--max-depth-mm", 0.3]
    want = command.json("lobes", "two-tooth-benchmark", *words)["scenarios"][0]
    found = rarma.lobes("two-tooth-benchmark", rpm=(8000, 12000), speeds=9, max_depth_mm=0.3)
    for name in ("speed_rpm", "depth_mm", "chatter_hz", "zero_order_mm"):
        told = [point[name] for point in want["points"]]
        assert [None if np.isnan(v) else v for v in found[name].tolist()] == told, name
    assert found["crossing"] == [point["crossing"] for point in want["points"]]
    assert found["scenario"] == want["scenario"] and found["most_mm"] == 0.3


def test_decode_gives_what_the_command_decodes(command, tmp_path):
    record = tmp_path / "box.frames"
    command("box", "--sim", "box-ldbb-leak", "--record", record)
    found = rarma.decode(record.read_bytes())
    assert found == command.lines("decode", record)
    assert found[0]["message"]["Hello"]["sample_rate_hz"] == 48_000.0
    assert rarma.decode(b"noise\0" + record.read_bytes()[:-3]) == found[:-1]
    with pytest.raises(ValueError, match="data: 5 bytes without a whole frame"):
        rarma.decode(b"noise")
    with pytest.raises(TypeError):
        rarma.decode("box.frames")


def test_every_shipped_scenario_is_named(command):
    listed = [line.split()[0] for line in command("simulate", "--list").splitlines()]
    assert list(rarma.scenarios()) == listed


def test_read_takes_a_channel_and_a_rate(tmp_path):
    table = tmp_path / "two.csv"
    rows = "\n".join(f"{t / 100},{np.sin(t)},{np.cos(t)}" for t in range(50))
    table.write_text("time,a,b\n" + rows + "\n")
    recording = rarma.read(table, channel=1)
    assert recording.samples == pytest.approx(np.cos(np.arange(50)))
    assert recording.sample_rate_hz == pytest.approx(100.0)
    assert recording.channels == 2 and recording.full_scale is None


@pytest.mark.parametrize(
    ("says", "call"),
    [
        ("order: 61,0: must have the form", lambda x: rarma.identify(x, FS, (61, 0))),
        ("method pem fits p up to 30, not 31", lambda x: rarma.identify(x, FS, (31, 0))),
        ("method burg fits autoregressive", lambda x: rarma.identify(x, FS, (4, 3), method="burg")),
        ("method: \"best\" is none of pem, ml", lambda x: rarma.identify(x, FS, (2, 1), method="best")),
        ("band_hz: both edges must be above 0", lambda x: rarma.identify(x, FS, (2, 1), band_hz=(0, 9))),
        ("band_hz: must have|band_hz: wide: must", lambda x: rarma.identify(x, FS, (2, 1), band_hz="wide")),
        ("x: end of data: 20 samples are too few", lambda x: rarma.identify(x[:20], FS, (8, 7), band_hz="full")),
        ("sample_rate_hz: 0: must lie", lambda x: rarma.identify(x, 0, (2, 1))),
        ("max_p: 31: must lie between 1 and 30", lambda x: rarma.order(x, FS, max_p=31)),
        ("order P,Q is needed for a model", lambda x: rarma.psd(x, FS, method="arma")),
        ("at_hz: 9000 Hz lies", lambda x: rarma.psd(x, FS, at_hz=9000)),
        ("nowhere: .*name a TOML file, or one of chatter-onset", lambda x: rarma.simulate("nowhere")),
        ("seed: -1: must be 0 or more", lambda x: rarma.simulate("turning-980", seed=-1)),
        ("speeds: 0: must lie between 1 and 20000", lambda x: rarma.lobes("turning-980", speeds=0)),
        ("nowhere.wav: ", lambda x: rarma.read("nowhere.wav")),
        ("channel: -1: ", lambda x: rarma.read("nowhere.wav", channel=-1)),
    ],
)  # fmt: skip
def test_bad_arguments_say_what_and_where(x, says, call):
    with pytest.raises(ValueError, match=says):
        call(x)


def test_a_band_that_is_none_is_of_the_wrong_type(x):
    with pytest.raises(TypeError, match="band_hz: 300 is no band"):
        rarma.identify(x, FS, (2, 1), band_hz=300)


def test_identify_channels(command, tmp_path):
    """Two sensors in a CSV and in an array."""
    first, second = vibration(MODES[:1], 8000), vibration(MODES[1:2], 8000, seed=2)
    x = np.column_stack([first + second, first - 0.5 * second])
    path = tmp_path / "x.csv"
    rows = np.column_stack([np.arange(len(x)) / FS, x])
    np.savetxt(path, rows, delimiter=",", fmt="%.17g", header="time,a,b", comments="")
    found = rarma.identify_channels(x, FS, 4, references=[1], rows=15, stretches=50, band_hz="full")
    words = ["--channels", "all", "--references", 1, "--rows", 15, "--stretches", 50]
    said = command.json("identify", path, "--order", "4,0", "--band", "full", *words)
    assert found == said
    assert [round(mode["f"], -2) for mode in found["modes"]] == [700, 1300]
    for wrong in (first, x[:, :0]):
        with pytest.raises(ValueError, match="x: shape"):
            rarma.identify_channels(wrong, FS, 4)
    with pytest.raises(TypeError, match=r"x\[:, 0\]: dtype int64"):
        rarma.identify_channels(x.astype(int), FS, 4)
    holed = x.copy()
    holed[5, 1] = np.nan
    with pytest.raises(ValueError, match=r"x\[:, 1\]\[5\]: NaN is no sample"):
        rarma.identify_channels(holed, FS, 4)
    with pytest.raises(ValueError, match="order"):
        rarma.identify_channels(x, FS, 0)
