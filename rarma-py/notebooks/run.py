"""Runs the notebooks beside it from top to bottom, and leaves them as they are.

    python -m pip install -r rarma-py/notebooks/requirements.txt and the wheel
    python rarma-py/notebooks/run.py [NOTEBOOK...]

Ends with 1 where a cell fails; the cell and what it said are told.
"""

from __future__ import annotations

import pathlib
import sys
import time

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

HERE = pathlib.Path(__file__).resolve().parent
# A cell that takes longer hangs, s.
PATIENCE_S = 600


def main() -> int:
    paths = [pathlib.Path(name) for name in sys.argv[1:]] or sorted(HERE.glob("*.ipynb"))
    failed = 0
    for path in paths:
        begun = time.monotonic()
        notebook = nbformat.read(path, as_version=4)
        client = NotebookClient(
            notebook,
            timeout=PATIENCE_S,
            kernel_name="python3",
            resources={"metadata": {"path": str(HERE)}},
        )
        try:
            client.execute()
        except CellExecutionError as why:
            failed += 1
            print(f"{path.name}: {why}")
        print(f"{path.name}: {time.monotonic() - begun:.1f} s", flush=True)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
