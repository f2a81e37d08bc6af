"""TDMS files of another implementation (npTDMS): what it writes is read, and what is put together
here by the format's description is read as it reads it."""

import struct

import numpy as np
import pytest
import rarma

nptdms = pytest.importorskip("nptdms")

RATE_HZ = 51_200.0


def written(path, segments):
    """Segments of objects, each as npTDMS writes it."""
    with nptdms.TdmsWriter(path) as file:
        for objects in segments:
            file.write_segment(objects)
    return path


def channel(group, name, data, **properties):
    return nptdms.ChannelObject(group, name, data, properties={"wf_increment": 1 / RATE_HZ, **properties})


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """A virtual cut in pieces, beside another channel, a group's remark, words and times."""
    virtual = rarma.simulate("chatter-onset")
    x, step = virtual.samples, 1 / virtual.sample_rate_hz
    noise = np.random.default_rng(5).standard_normal(len(x))
    segments = []
    for a, b in zip([0, 1000, 1001, 40_000], [1000, 1001, 40_000, len(x)]):
        segments.append(
            [
                nptdms.RootObject({"author": "nobody", "when": np.datetime64("2024-01-01")}),
                nptdms.GroupObject("Vibration", {"machine": "M3"}),
                channel("Vibration", "other", noise[a:b], wf_increment=step),
                channel("Vibration", "it's x", x[a:b], wf_increment=step, unit_string="m/s^2"),
            ]
        )
    segments.append([nptdms.ChannelObject("Notes", "words", ["begin", "end"])])
    path = tmp_path_factory.mktemp("tdms") / "run.tdms"
    return written(path, segments), x, virtual.sample_rate_hz


def test_what_another_implementation_writes_is_read(cut):
    path, x, rate = cut
    recording = rarma.read(path, channel=1)
    assert recording.sample_rate_hz == rate and recording.channels == 2 and recording.full_scale is None
    assert np.array_equal(recording.samples, x)
    assert recording.notices == ["1 of 3 channels left out: empty, or no numbers over time"]
    with pytest.raises(ValueError, match="channel 2 asked for, but there are 2: 0 'Vibration/other', 1 'Vibration/it's x' in m/s"):
        rarma.read(path, channel=2)


def test_the_unit_goes_with_the_samples_wherever_they_are_converted_to(command, cut, tmp_path):
    path, x, _ = cut
    header = lambda file: file.read_text(encoding="utf-8").splitlines()[2]  # noqa: E731
    for words, told in (([], "m/s^2"), (["--unit", "g"], "g")):
        command("convert", path, "--out", tmp_path / "run.uff", *words)
        command("convert", tmp_path / "run.uff", "--out", tmp_path / "run.csv")
        # The first channel has no unit: parts of full scale, unless it is told.
        first = words[-1] if words else "1"
        assert header(tmp_path / "run.csv") == f"time_s,channel 0 ({first}),channel 1 ({told})"
    for name in ("run.uff", "run.csv"):
        recording = rarma.read(tmp_path / name, channel=1)
        assert recording.sample_rate_hz == rarma.read(path, channel=1).sample_rate_hz
        assert np.allclose(recording.samples, x, rtol=0, atol=1e-11), name


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8"])
def test_every_kind_of_number(tmp_path, kind):
    values = (np.sin(np.arange(3000) * 0.3) * 100 + (100 if kind[0] == "u" else 0)).astype(kind)
    path = written(tmp_path / "a.tdms", [[channel("g", "x", values)], [channel("g", "x", values[:100])]])
    recording = rarma.read(path)
    assert recording.sample_rate_hz == RATE_HZ
    assert np.array_equal(recording.samples, np.concatenate([values, values[:100]]).astype(float))


def test_the_command_says_of_it_what_it_says_of_the_same_samples(command, cut, tmp_path):
    path, x, rate = cut
    raw = tmp_path / "run.f64"
    raw.write_bytes(x.astype("<f8").tobytes())
    of_tdms, of_raw = ["--channel", 1], ["--fs", rate]
    told = ["--rpm", 9000, "--teeth", 4]
    for words in (["monitor", *told], ["identify", "--order", "4,3"], ["psd", "--method", "welch"]):
        name, *options = words
        lines = [command.lines(name, file, *options, *own) for file, own in ((path, of_tdms), (raw, of_raw))]
        assert lines[0] == lines[1] and lines[0], name
    records = rarma.Monitor(rate, rpm=9000, teeth=4).push(rarma.read(path, channel=1).samples)
    assert records == command.lines("monitor", path, *told, *of_tdms)[:-1]


def bytes_of(rng, file_channels, segments):
    """A file by the description of the format, of a random layout; the samples are whole numbers."""
    kinds = {"i2": 2, "i4": 3, "f4": 9, "f8": 10}
    out, last, listed = b"", {}, []
    for number in range(segments):
        big, in_turn = rng.integers(2), rng.integers(2)
        end = ">" if big else "<"
        new = number == 0 or rng.integers(2)
        if new:
            listed = [str(name) for name in rng.permutation(file_channels)[: rng.integers(1, len(file_channels) + 1)]]
        same = int(rng.integers(1, 60))
        said, counts = b"", {}
        says = new or rng.integers(2)
        for name in listed if says else ():
            kind = "f8" if name == "a" else ["i2", "i4", "f4"][ord(name) % 3]
            count = same if in_turn else int(rng.integers(1, 60))
            path = f"/'g'/'{name}'".encode()
            said += struct.pack(end + "I", len(path)) + path
            if name in last and not in_turn and rng.integers(2):
                said += struct.pack(end + "I", 0)
            else:
                last[name] = count
                said += struct.pack(end + "IIIQ", 20, kinds[kind], 1, count)
            first = name not in counts and number == 0
            said += struct.pack(end + "I", 1 if first else 0)
            if first:
                said += struct.pack(end + "I", 12) + b"wf_increment" + struct.pack(end + "Id", 10, 1 / RATE_HZ)
        counts = {name: last[name] for name in listed}
        # Values in turn need one number of them for all.
        in_turn = bool(in_turn and len(set(counts.values())) == 1)
        if says:
            said = struct.pack(end + "I", len(listed)) + said
        raw = b""
        for _ in range(rng.integers(1, 4)):
            columns = []
            for name in listed:
                kind = "f8" if name == "a" else ["i2", "i4", "f4"][ord(name) % 3]
                columns.append(rng.integers(-999, 999, counts[name]).astype(end + kind))
            if in_turn:
                raw += b"".join(value.tobytes() for row in zip(*columns) for value in row)
            else:
                raw += b"".join(column.tobytes() for column in columns)
        bits = (2 if says else 0) | (4 if new else 0) | 8 | (32 if in_turn else 0) | (64 if big else 0)
        out += b"TDSm" + struct.pack("<I", bits) + struct.pack(end + "IQQ", 4713, len(said) + len(raw), len(said)) + said + raw
    return out


def test_any_layout_is_read_as_another_implementation_reads_it(tmp_path):
    rng = np.random.default_rng(12)
    compared = 0
    for k in range(300):
        names = list("abcd"[: rng.integers(1, 5)])
        path = tmp_path / "a.tdms"
        path.write_bytes(bytes_of(rng, names, int(rng.integers(1, 7))))
        theirs = [c[:].astype(float) for c in nptdms.TdmsFile.read(path)["g"].channels()]
        for number, samples in enumerate(theirs):
            try:
                ours = rarma.read(path, channel=number, sample_rate_hz=RATE_HZ).samples
            except ValueError as why:
                # One value, or all of them the same: nothing to be analysed, however it is read.
                assert len(set(samples.tolist())) < 2, (k, number, why)
                continue
            assert np.array_equal(ours, samples), (k, number)
            compared += 1
    assert compared > 500


def test_scales_are_those_of_another_implementation(tmp_path):
    counts = np.arange(-1000, 1000, dtype="i2")
    scales = {
        "NI_Number_Of_Scales": np.uint32(2),
        "NI_Scaling_Status": "unscaled",
        "NI_Scale[0]_Scale_Type": "Polynomial",
        "NI_Scale[0]_Polynomial_Coefficients_Size": np.uint32(3),
        "NI_Scale[0]_Polynomial_Coefficients[0]": 0.5,
        "NI_Scale[0]_Polynomial_Coefficients[1]": 0.25,
        "NI_Scale[0]_Polynomial_Coefficients[2]": 0.125,
        "NI_Scale[0]_Polynomial_Input_Source": np.uint32(0xFFFFFFFF),
        "NI_Scale[1]_Scale_Type": "Linear",
        "NI_Scale[1]_Linear_Slope": 2.0,
        "NI_Scale[1]_Linear_Y_Intercept": -1.0,
        "NI_Scale[1]_Linear_Input_Source": np.uint32(0),
    }
    path = written(tmp_path / "a.tdms", [[channel("g", "x", counts, **scales)]])
    theirs = nptdms.TdmsFile.read(path)["g"]["x"][:]
    assert np.array_equal(theirs, 0.25 * counts.astype(float) ** 2 + 0.5 * counts)
    assert np.array_equal(rarma.read(path).samples, theirs)


def test_what_is_not_read_is_said_in_one_line(tmp_path):
    x = np.sin(np.arange(1000) * 0.3)
    bare = written(tmp_path / "bare.tdms", [[nptdms.ChannelObject("g", "x", x)]])
    with pytest.raises(ValueError, match="bare.tdms: channel 'g/x': no sampling rate: the property wf_increment is missing"):
        rarma.read(bare)
    assert rarma.read(bare, sample_rate_hz=8000.0).sample_rate_hz == 8000.0
    whole = written(tmp_path / "whole.tdms", [[channel("g", "x", x)], [channel("g", "x", x)]])
    cut = tmp_path / "cut.tdms"
    cut.write_bytes(whole.read_bytes()[:-1000])
    recording = rarma.read(cut)
    assert np.array_equal(recording.samples, np.concatenate([x, x[:875]]))
    assert recording.notices == ["the file ends 1000 bytes before segment 2 does: read as far as it goes"]
    cut.write_bytes(whole.read_bytes()[:60])
    with pytest.raises(ValueError, match="cut.tdms: segment 1, byte 0: the file ends inside the description of its channels"):
        rarma.read(cut)
