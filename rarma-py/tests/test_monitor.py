"""Monitor, advise and their tables: what the command says of the same samples in a file."""

import numpy as np
import pytest
import rarma

SCENARIO = "chatter-onset"


@pytest.fixture(scope="module")
def cut(command, tmp_path_factory):
    """A virtual cut as a file, and what is true of it."""
    folder = tmp_path_factory.mktemp("cut")
    wav = folder / "cut.wav"
    command("simulate", SCENARIO, "--out", wav, "--truth", folder / "truth.json")
    return wav


def pieces(x, seed=3):
    cuts = np.sort(np.random.default_rng(seed).integers(1, len(x), 40))
    return [part for part in np.split(x, cuts) if len(part)]


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ([], {}),
        (["--rpm", "9000", "--teeth", "4"], {"rpm": 9000, "teeth": 4}),
        (
            ["--order", "4,3", "--band", "200:1500", "--threshold", "0.02", "--every", "0.05"],
            {"order": (4, 3), "band_hz": (200, 1500), "threshold": 0.02, "every_s": 0.05},
        ),
        (
            ["--idle", "0:0.3", "--aliased", "--rpm", "1680", "--set", "memory_s=0.25"],
            {"idle_s": (0, 0.3), "aliased": True, "rpm": 1680, "set": {"memory_s": 0.25}},
        ),
    ],
)
def test_the_same_records_and_summary_as_the_command(command, cut, words, options):
    *lines, last = command.lines("monitor", cut, *words)
    recording = rarma.read(cut)
    assert recording.full_scale == 1.0 and recording.notices == []
    monitor = rarma.Monitor(recording.sample_rate_hz, full_scale=1.0, **options)
    records = [record for part in pieces(recording.samples) for record in monitor.push(part)]
    assert len(records) > 20
    assert records == lines
    assert monitor.summary() == last["summary"]
    # A summary ends nothing.
    assert monitor.summary() == last["summary"]


def test_chatter_is_called_and_advice_given_as_by_the_command(command, cut):
    truth = rarma.simulate(SCENARIO).truth
    told = {"rpm": truth["speed_rpm"], "teeth": truth["teeth"]}
    words = ["--rpm", told["rpm"], "--teeth", told["teeth"], "--reach", "60:140", "--power", "1.3"]
    x, sample_rate_hz, full_scale, *_ = rarma.read(cut)
    options = {"full_scale": full_scale, "reach_percent": (60, 140), "power": 1.3}
    found = rarma.advise(x, sample_rate_hz, **told, **options)
    assert found == command.json("advise", cut, *words)
    assert found["missing"] == [] and found["alarms"][0]["advice"]["speeds"]
    assert truth["onset_s"] < found["alarms"][0]["on"]
    assert rarma.advise(x, sample_rate_hz)["missing"] == ["speed", "teeth"]


def test_a_structure_is_told_by_its_file(command, cut, tmp_path):
    structure = tmp_path / "structure.csv"
    structure.write_text("f,f_sd,zeta,zeta_sd\n980,0.4,0.02,0.0003\n")
    *lines, _ = command.lines("monitor", cut, "--structure", structure)
    x, sample_rate_hz, *_ = rarma.read(cut)
    monitor = rarma.Monitor(sample_rate_hz, full_scale=1.0, structure=structure)
    records = monitor.push(x)
    assert records == lines
    assert any("zeta_process" in mode for record in records for mode in record["modes"])


def test_lost_samples_and_a_told_speed_count(cut):
    x, sample_rate_hz, *_ = rarma.read(cut)
    monitor = rarma.Monitor(sample_rate_hz)
    monitor.push(x[:48_000])
    monitor.missing(4800)
    monitor.tell_speed(9000.0)
    records = monitor.push(x[48_000:])
    summary = monitor.summary()
    assert summary["samples"] == len(x) + 4800
    assert any(record["reason"] == "samples-missing" for record in records)
    assert records[-1]["spindle"]["rpm"] == pytest.approx(9000.0)
    with pytest.raises(ValueError, match="rpm: -1: must lie between 0.06 and 300000"):
        monitor.tell_speed(-1.0)


def test_tables_hold_every_mode_of_every_record(cut):
    pandas = pytest.importorskip("pandas")
    x, sample_rate_hz, *_ = rarma.read(cut)
    records = rarma.Monitor(sample_rate_hz).push(x)
    table = rarma.to_numpy(records)
    assert len(table) == sum(max(1, len(record["modes"])) for record in records)
    with_modes = table[table["mode"] >= 0]
    flat = [(r["t"], m["f"], m["zeta_sd"], m["label"]) for r in records for m in r["modes"]]
    assert with_modes[["t", "f", "zeta_sd", "label"]].tolist() == flat
    frame = rarma.to_pandas(records)
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == list(table.dtype.names)
    assert frame["zeta"].equals(pandas.Series(table["zeta"]))
    with pytest.raises(ValueError, match=r"records\[0\]: no record of a monitor"):
        rarma.to_numpy([{"t": 1.0}])


def test_readings_as_a_table():
    pandas = pytest.importorskip("pandas")
    x = np.random.default_rng(1).standard_normal(4000)
    model = rarma.RecursiveArma(4, 3, 8000.0)
    readings = model.push(x, every=100)
    frame = rarma.to_pandas(readings, 8000.0, every=100)
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 40 * 2
    last = frame[frame["mode"] == 1].iloc[-1]
    assert last["sample"] == 3999 and last["t"] == 3999 / 8000.0
    assert last["f_hz"] == readings.f_hz[-1, 1] or np.isnan(readings.f_hz[-1, 1])


@pytest.mark.parametrize(
    ("says", "rate", "options"),
    [
        ("sample_rate_hz: -1: must lie between", -1.0, {}),
        ("sample_rate_hz: NaN: `NaN` is not finite", float("nan"), {}),
        ("order: the box does not have order 3,3 .it has 2,1", 48e3, {"order": (3, 3)}),
        ("order: 31,2: must have the form", 48e3, {"order": (31, 2)}),
        ("rpm: -3: must be above 0", 48e3, {"rpm": -3}),
        ("teeth: 0: ", 48e3, {"teeth": 0}),
        ("threshold: 0.5: must lie between 0.0005 and 0.2", 48e3, {"threshold": 0.5}),
        ("band_hz: both edges must be above 0", 48e3, {"band_hz": (900, 300)}),
        ("x: header: 8000 Hz is too low a rate for a band up to 9000 Hz .choose band_hz", 8e3, {"band_hz": (300, 9000)}),
        ("idle_s: 3:1: must start", 48e3, {"idle_s": (3, 1)}),
        ("every_s: 0: must lie between", 48e3, {"every_s": 0}),
        ("set foo=1: ", 48e3, {"set": {"foo": 1}}),
        ("full_scale: -1: must be above 0", 48e3, {"full_scale": -1}),
        ("nowhere.json: ", 48e3, {"structure": "nowhere.json"}),
        ("reach_percent: 9:1: must rise", 48e3, {"reach_percent": (9, 1)}),
    ],
)  # fmt: skip
def test_bad_settings_say_what_and_where(says, rate, options):
    with pytest.raises(ValueError, match=says):
        rarma.Monitor(rate, **options)
