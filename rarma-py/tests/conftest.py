"""The command beside the package: what both say must be the same."""

import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Command:
    """Runs `rarma`."""

    def __init__(self, program):
        self.program = program

    def __call__(self, *arguments):
        """What it prints; chatter that was found is exit code 1 and no failure."""
        words = [self.program, *map(str, arguments)]
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode in (0, 1), f"{words}: {done.stderr}"
        return done.stdout

    def json(self, *arguments):
        return json.loads(self(*arguments, "--json"))

    def lines(self, *arguments):
        return [json.loads(line) for line in self(*arguments, "--json").splitlines()]


@pytest.fixture(scope="session")
def command():
    program = os.environ.get("RARMA_PROGRAM", ROOT / "target/release/rarma")
    if not pathlib.Path(program).is_file():
        pytest.fail(f"no {program}: cargo build --release -p rarma-cli")
    return Command(str(program))
