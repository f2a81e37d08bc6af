"""The Python on docs/python.md runs as it stands there."""

import re

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
    assert " Hz ± " in said and "chatter" in said and "'speeds'" in said
    assert names["monitor"].summary()["alarms"]
