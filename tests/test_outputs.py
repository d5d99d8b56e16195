"""The files of a fit: all of one fit or none, whatever comes between, and errors that are one message."""

import dataclasses
import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from result_samples import save_scene, small_result, view

from diffwhitted.image import read_image
from fitting.telling import _outputs
from fitting.telling._outputs import OutputError, write_outputs


@pytest.fixture
def result():
    return small_result()


def test_outputs(result, tmp_path):
    folder = tmp_path / "new" / "folder"
    two = dataclasses.replace(result, views=(view("a/b"), view("a b", 4, 5)))
    written = write_outputs(two, folder, title="t", save_scene=save_scene, metadata={"target": "x.exr"})
    pictures = ["render_a_b.exr", "residual_a_b.exr", "render_a_b_2.exr", "residual_a_b_2.exr"]
    names = ["result.json", "fitted.toml", *pictures, "report.html"]
    assert [path.name for path in written] == names and sorted(os.listdir(folder)) == sorted(names)
    assert json.loads((folder / "result.json").read_text())["metadata"] == {"target": "x.exr"}
    np.testing.assert_array_equal(read_image(folder / "residual_a_b_2.exr").pixels, two.views[1].residual)
    np.testing.assert_array_equal(read_image(folder / "render_a_b.exr").pixels, two.views[0].render)
    again = write_outputs(result, folder, title="t", save_scene=save_scene)
    assert [path.name for path in again][2:4] == ["render.exr", "residual.exr"]


def test_a_failing_write_leaves_the_folder_as_it_was(result, tmp_path, monkeypatch):
    def broken(scene, path):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    (tmp_path / "fitted.toml").write_text("before")
    with pytest.raises(OutputError, match=r"fitted\.toml: no space left on device; check that the disk") as caught:
        write_outputs(result, tmp_path, title="t", save_scene=broken)
    assert "\n" not in str(caught.value) and isinstance(caught.value, OSError)
    assert sorted(os.listdir(tmp_path)) == ["fitted.toml", "unfinished"]
    assert (tmp_path / "fitted.toml").read_text() == "before"

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(_outputs, "report_html", interrupted)
        with pytest.raises(KeyboardInterrupt):
            write_outputs(result, tmp_path, title="t", save_scene=save_scene)
    # The numbers of a long fit are there, whatever the report met.
    assert sorted(os.listdir(tmp_path)) == ["fitted.toml", "unfinished"]
    assert json.loads((tmp_path / "unfinished" / "result.json").read_text())["status"] == result.status
    write_outputs(result, tmp_path, title="t", save_scene=save_scene)
    assert "unfinished" not in os.listdir(tmp_path) and "result.json" in os.listdir(tmp_path)


@pytest.mark.parametrize("killed_at", range(12))
def test_a_folder_with_a_result_is_of_one_fit_whenever_the_program_is_killed(result, tmp_path, monkeypatch, killed_at):
    """Killed before any of the steps that change the folder: with result.json in it, every file is of the same fit."""
    names = ["result.json", "fitted.toml", "render.exr", "residual.exr", "report.html"]
    write_outputs(result, tmp_path, title="first", save_scene=save_scene, metadata={"run": 1})
    first = {name: (tmp_path / name).read_bytes() for name in names}
    steps = 0

    def step(real):
        def killing(*arguments, **options):
            nonlocal steps
            if Path(arguments[0]).parent in (tmp_path, tmp_path / "unfinished"):
                steps += 1
                if steps > killed_at:
                    raise SystemExit
            return real(*arguments, **options)

        return killing

    with monkeypatch.context() as patched:
        patched.setattr(_outputs.os, "replace", step(os.replace))
        patched.setattr(Path, "unlink", step(Path.unlink))
        other = dataclasses.replace(result, views=(view("main", 4, 5),), scene="the scene of another fit")
        try:
            write_outputs(other, tmp_path, title="second", save_scene=save_scene, metadata={"run": 2})
        except SystemExit:
            pass
    now = {name: (tmp_path / name).read_bytes() for name in names if (tmp_path / name).exists()}
    if "result.json" in now:
        same = {name: now[name] == first[name] for name in names}
        assert len(set(same.values())) == 1, same


def test_a_folder_that_cannot_be_written_is_one_message(result, tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OutputError, match=f"cannot write {re.escape(str(folder))}: a file stands where .* --out"):
            write_outputs(result, folder, title="t", save_scene=save_scene)
    for name in ("result.json", "render.exr"):
        folder = tmp_path / name
        (folder / name).mkdir(parents=True)
        with pytest.raises(OutputError, match=re.escape(name)):
            write_outputs(result, folder, title="t", save_scene=save_scene)
        assert not [left for left in os.listdir(folder) if left.startswith(".")]
