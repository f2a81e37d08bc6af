"""The type stubs are those of the module, and everything public is explained."""

import inspect
import subprocess
import sys

import pytest
import rarma


def test_the_stubs_match_the_module():
    pytest.importorskip("mypy")
    check = [sys.executable, "-m", "mypy.stubtest", "rarma._rarma", "--ignore-disjoint-bases"]
    done = subprocess.run(check, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_everything_public_is_explained():
    for name in rarma.__all__:
        thing = getattr(rarma, name)
        assert (thing.__doc__ or "").strip(), name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and not inspect.isclass(value):
                assert (getattr(value, "__doc__", "") or "").strip(), f"{name}.{member}"
