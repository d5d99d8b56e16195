"""Odd files and odd names: what is no regular file is refused at once, and nothing that a name holds steers a
terminal.
"""

import os
import signal
import socket
import sys
import types

import numpy as np
import pytest
from rich.console import Console

import diffwhitted as dw
from diffwhitted._errors import printable
from diffwhitted.image import ImageError, read_image, read_mask, write_image
from fitting._result import FittedCoefficient
from fitting.command_line import _noted, main
from fitting.command_line._accuracy import _read
from fitting.command_line._explain import print_explanation
from fitting.command_line._named_values import true_values
from fitting.telling._outputs import OutputError, write_together, write_whole
from fitting.telling._tables import coefficient_table

RED = "\x1b[31m"


@pytest.fixture(autouse=True)
def _no_waiting():
    """Whoever opens a named pipe waits for its other end."""

    def late(*_):
        raise TimeoutError("it waits")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe.toml"
    os.mkfifo(path)
    return path


def test_a_named_pipe_is_refused_wherever_a_file_is_read(pipe):
    with pytest.raises(dw.SceneError, match="pipe.toml: this is a named pipe; write the scene to a file"):
        dw.load_scene(pipe)
    for read in (read_image, read_mask):
        with pytest.raises(ImageError, match="not a file but a named pipe"):
            read(pipe)
    values = pipe.rename(pipe.with_suffix(".json"))
    with pytest.raises(dw.InputError, match="--truth .*: this is a named pipe"):
        true_values(values, dw.Scene(objects=[], materials={}), [])
    assert _read(values) == {}


def test_a_named_pipe_is_refused_wherever_a_file_is_written(pipe, tmp_path):
    scene = dw.Scene(objects=[], materials={})
    with pytest.raises(dw.SceneError, match="this is a named pipe, which would be lost"):
        dw.save_scene(scene, pipe)
    with pytest.raises(OutputError, match="there is a named pipe of this name"):
        write_together(tmp_path, {pipe.name: lambda path: path.write_text("")}, pipe.name)
    with pytest.raises(OSError, match="there is a named pipe of this name"):
        write_whole(pipe, lambda path: path.write_text(""))
    picture = pipe.rename(tmp_path / "pipe.exr")
    with pytest.raises(ImageError, match="this is a named pipe, which would be lost"):
        write_image(picture, np.zeros((2, 2, 3), np.float32))
    assert picture.is_fifo()


def test_a_socket_and_a_device_are_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind("socket.toml")
        with pytest.raises(dw.SceneError, match="this is a socket"):
            dw.load_scene("socket.toml")
    with pytest.raises(dw.SceneError, match="this is a device"):
        dw.load_scene("/dev/null")


@pytest.mark.parametrize(
    "name, shown",
    [
        (RED + "x", r"\x1b[31mx"),
        ("a\rb\x9b1m", r"a\rb\x9b1m"),
        ("txt\u202egpj", r"txt\u202egpj"),
        ("half\udcff", r"half\udcff"),
        ("Glas-Kugel, größer als 1 µm: ガラス", "Glas-Kugel, größer als 1 µm: ガラス"),
        ("two\n  lines\tand a tab", "two\n  lines\tand a tab"),
    ],
)
def test_what_steers_a_terminal_is_written_out(name, shown):
    assert printable(name) == shown and str(dw.InputError(name)) == shown


@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
def test_names_of_files_reach_the_terminal_written_out(tmp_path, capfd):
    """Errors of ours and of the options, and the line that says what was written."""
    missing = tmp_path / f"no{RED}such.toml"
    assert main(["render", str(missing), "-o", str(tmp_path / "x.png")]) == 2
    assert main(["render", f"--{RED}depth", "1"]) == 2
    (tmp_path / "empty.toml").write_text(
        "[[camera]]\nlook_from=[0,0,4]\nlook_at=[0,0,0]\nvfov_deg=40\nwidth=4\nheight=3\n"
    )
    assert main(["render", str(tmp_path / "empty.toml"), "-o", str(tmp_path / f"{RED}.exr")]) == 0
    out, err = capfd.readouterr()
    assert "\x1b" not in out + err
    assert r"no\x1b[31msuch.toml: there is no such file" in err and r"\x1b[31m.exr" in out


def test_names_of_materials_reach_the_terminal_written_out(capsys):
    """The table and the sentences of a fit, and the reasons of `explain`."""
    name, channel = f"{RED}glass", FittedCoefficient
    fitted = channel(f"{name}.k_d", "k_d", 0.1, 0.5, None, None, False, True, (f"{name}.k_a",), False, (0.0, 1.0), "1")
    with_names = types.SimpleNamespace(coefficients=(fitted,), rank=0)
    Console(file=sys.stdout, width=80).print(coefficient_table(with_names))
    scene = dw.Scene(
        objects=[dw.Sphere(name, (0, 0, 0), 1, "m")],
        materials={"m": dw.Material(k_a=0.5)},
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 4, 3)},
    )
    print_explanation(dw.explain(scene, scene.cameras["main"], measure=False), f"{RED}.toml, camera main")
    written = capsys.readouterr().out
    assert "\x1b" not in written and r"\x1b[31mglass.k_d" in written and r"object '\x1b[31mglass'" in written
    assert r"\x1b[31m.toml" in written


def test_names_of_numbers_reach_the_terminal_written_out(tmp_path, capfd):
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, f"{RED}m")],
        materials={f"{RED}m": dw.Material(k_a=0.5)},
        cameras={f"{RED}main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 4, 3)},
    )
    dw.save_scene(scene, tmp_path / "scene.toml")
    assert main(["parameters", str(tmp_path / "scene.toml")]) == 0
    out, err = capfd.readouterr()
    assert "\x1b" not in out + err
    assert r"\x1b[31mm.k_a" in out and r"\x1b[31mm.k_t = 0, so" in out


def test_a_warning_of_ours_is_a_note(capsys):
    """Where the command line shows warnings; others are shown as Python does."""
    shown = []
    _noted(lambda *a: shown.append(a), dw.FarFromOrigin(f"far {RED}away"), dw.FarFromOrigin, "file.py", 1)
    assert capsys.readouterr().err == "note: far \\x1b[31maway\n" and not shown
    _noted(lambda *a: shown.append(a), UserWarning("x"), UserWarning, "file.py", 1)
    assert len(shown) == 1 and not capsys.readouterr().err
