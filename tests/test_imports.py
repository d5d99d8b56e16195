"""Imports pay for what is used."""

import subprocess
import sys

import pytest

import diffwhitted.image


@pytest.mark.parametrize(
    "statement, waiting",
    [
        ("import diffwhitted", "pydantic tomlkit OpenImageIO scipy.stats matplotlib colour optimistix rich"),
        ("import fitting.command_line", "jax equinox numpy pydantic OpenImageIO"),
        ("import diffwhitted; diffwhitted.load_scene", "OpenImageIO scipy.stats matplotlib colour"),
        ("import diffwhitted; diffwhitted.read_image", "pydantic scipy.stats matplotlib colour"),
    ],
)
def test_what_waits_until_it_is_asked_for(statement, waiting):
    script = f"import sys; {statement}; print(*(name for name in {waiting.split()} if name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == ""


def test_names_that_wait_are_there_and_others_are_not():
    for package in (diffwhitted, diffwhitted.image):
        assert all(
            getattr(package, name).__name__ == name for name in package.__all__ if callable(getattr(package, name))
        )
        with pytest.raises(AttributeError, match="no attribute 'nothing'"):
            _ = package.nothing
