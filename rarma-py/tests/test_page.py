"""The Python on docs/python.md runs as it stands there."""

import re

import numpy as np
from conftest import ROOT


def test_the_blocks_of_the_page_run(command, tmp_path, monkeypatch, capsys):
    command("simulate", "chatter-onset", "--out", tmp_path / "cut.wav")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.S)
    assert len(blocks) >= 2
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    said = capsys.readouterr().out
    # The modes that the page names, within five deviations.
    f_hz, sd_f_hz = names["f_hz"][-1], names["sd_f_hz"][-1]
    assert np.all(np.abs(f_hz - [700, 1300]) < 5 * sd_f_hz) and np.all(sd_f_hz < 3)
    assert np.all(np.abs(names["zeta"][-1] - [0.02, 0.03]) < 5 * names["sd_zeta"][-1])
    assert " Hz ± " in said and "chatter" in said and "'speeds'" in said
    assert names["monitor"].summary()["alarms"]
