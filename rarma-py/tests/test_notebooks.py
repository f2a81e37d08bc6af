"""The notebooks hold no results, only what makes them, and the page names each.

They are run by ``rarma-py/notebooks/run.py``, which `cargo verify` calls.
"""

import json

import pytest
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "rarma-py/notebooks").glob("*.ipynb"))


def test_there_are_notebooks():
    assert len(NOTEBOOKS) >= 5


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_outputs_are_stripped(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and cells[0]["cell_type"] == "markdown"
    for cell in code:
        assert cell["outputs"] == [] and cell["execution_count"] is None, (
            f"{path.name} holds results; in Jupyter: Edit, Clear Outputs of All Cells"
        )


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_the_page_names_it(path):
    page = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    assert f"../rarma-py/notebooks/{path.name}" in page
