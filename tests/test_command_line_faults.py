"""What the command line cannot use: one message, an exit code, and nothing written."""

import numpy as np
import pytest

from diffwhitted import CapacityError
from diffwhitted.image import write_image
from fitting.command_line import main
from fitting.command_line._failures import failed

FIT = ["fit", "scene.toml", "--free", "paint.k_d", "--out", "out", "--target"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["render", "broken.toml", "-o", "a.png"], "broken.toml: broken TOML"),
        (["render", "scene.toml", "-o", "a.bmp"], "cannot write the extension '.bmp'"),
        (["render", "scene.toml", "-o", "none/a.png"], "does not exist"),
        (["render", "scene.toml", "-o", "a.exr", "--exposure", "1"], "exposure = 1.0 is for display"),
        (["render", "scene.toml", "-o", "a.png", "--camera", "mian"], "Did you mean 'main'?"),
        (["render", "scene.toml", "-o", "a.png", "--samples", "0"], "--samples"),
        (["render", "scene.toml"], "'--out'"),
        (["rendre", "scene.toml"], "Did you mean 'render'?"),
        ([*FIT, "none.exr"], "none.exr: no such file"),
        ([*FIT, "wide.exr"], "the picture has 20x12 pixels, the camera 16x12"),
        ([*FIT, "nan.exr"], "NaN"),
        ([*FIT, "side=target.exr"], "no camera 'side'; there is main"),
        ([*FIT, "target.exr", "target.exr"], "two files for camera 'main'"),
        ([*FIT, "target.exr", "--free", "glass.*"], "'glass.*' matches no coefficient"),
        ([*FIT, "target.exr", "--out", "broken.toml"], "a folder is needed"),
        ([*FIT, "target.exr", "--mask", "side=target.exr"], "no camera 'side'"),
        ([*FIT, "target.exr", "--start", "paint.k_d"], "allowed is NAME=VALUE"),
        ([*FIT, "target.exr", "--bounds", "paint.k_d=0.1"], "allowed is NAME=LOW:HIGH"),
        ([*FIT, "target.exr", "--start", "paint.k_d=much"], "'much' is not a number"),
        ([*FIT, "target.exr", "--truth", "other.json"], "holds none of the free coefficients"),
        (["explain", "scene.toml", "--free", "paint.kd"], "Did you mean 'paint.k_d'?"),
    ],
)
def test_what_cannot_be_used(place, capsys, arguments, said):
    (place / "broken.toml").write_text("[scene")
    (place / "other.json").write_text('{"a.k_d": 1}')
    write_image("wide.exr", np.zeros((12, 20, 3)))
    write_image("nan.exr", np.full((12, 16, 3), np.nan))
    before = set(place.iterdir())
    assert main(arguments) == 2
    heard = capsys.readouterr()
    assert heard.out == ""
    assert heard.err.startswith("error: ") and heard.err.count("\n") == 1
    assert said in heard.err
    assert set(place.iterdir()) == before


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (CapacityError("the ray tree needs more room"), 1, "more room"),
        (MemoryError(), 2, "not enough memory"),
        (RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 9 bytes"), 2, "not enough memory"),
        (PermissionError(13, "x", "place/file"), 2, "place/file: permission denied"),
        (KeyError("a"), 1, "unexpected KeyError"),
    ],
)
def test_errors_and_their_exit_codes(capsys, error, code, said):
    assert failed(error) == code
    heard = capsys.readouterr().err
    assert heard.startswith("error: ") and heard.count("\n") == 1
    assert said in heard
