"""JPEG targets, and averages over pixels: errors of pictures that are no noise, and that a fit knows of."""

import numpy as np
import OpenImageIO as oiio
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.image import encode_signal
from diffwhitted.image._jpeg import Jpeg, jpeg_of

TRUE = {
    "paint.k_a": 0.1, "paint.k_d.r": 0.6, "paint.k_d.g": 0.35, "paint.k_d.b": 0.15, "paint.k_h": 0.3,
    "paint.phong_exponent": 20.0,
}  # fmt: skip
FREE = ["paint.k_a", "paint.k_d", "paint.k_h", "paint.phong_exponent"]
START = {"paint.k_a": 0.05, "paint.k_d": 0.3, "paint.k_h": 0.2, "paint.phong_exponent": 10.0}


def scene():
    """An orange ball before a blue wall: colours that a codec takes together at the edge."""
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint"), dw.Plane("wall", (0, 0, 1), -2, "wall")],
        materials={
            "paint": dw.Material(k_a=0.1, k_d=(0.6, 0.35, 0.15), k_h=0.3, phong_exponent=20),
            "wall": dw.Material(k_d=(0.05, 0.1, 0.4)),
        },
        lights=[dw.PointLight((-2, 3, 5), 0.9)],
        ambient=(0.3, 0.3, 0.3),
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 48, 32)},
    )


def shown(samples=1):
    world = scene()
    return np.asarray(dw.render(world, world.cameras["main"], samples=samples), np.float64)


def write(path, picture, quality, subsampling):
    codes = np.rint(255 * np.clip(encode_signal(picture, "srgb"), 0, 1)).astype(np.uint8)
    spec = oiio.ImageSpec(codes.shape[1], codes.shape[0], 3, "uint8")
    for name, value in {"CompressionQuality": quality, "jpeg:subsampling": subsampling}.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(codes) and output.close()
    return codes


@pytest.mark.parametrize("quality, subsampling", [(90, "4:2:0"), (75, "4:4:4"), (31, "4:2:2"), (100, "4:2:0")])
def test_how_a_file_was_compressed_is_read_from_it(tmp_path, quality, subsampling):
    """And the same compression gives the same codes."""
    codes = write(tmp_path / "a.jpg", shown(), quality, subsampling)
    found = jpeg_of(tmp_path / "a.jpg")
    assert found == Jpeg(quality, subsampling) and dw.read_image(tmp_path / "a.jpg").jpeg == found
    read = oiio.ImageInput.open(str(tmp_path / "a.jpg")).read_image("uint8")
    np.testing.assert_array_equal(found.of(codes), read)


def test_files_of_other_programs_and_broken_ones_are_not_guessed_at(tmp_path):
    write(tmp_path / "a.jpg", shown(), 90, "4:2:0")
    content = bytearray((tmp_path / "a.jpg").read_bytes())
    content[content.index(b"\xff\xdb") + 8] += 1
    (tmp_path / "own_tables.jpg").write_bytes(content)
    assert jpeg_of(tmp_path / "own_tables.jpg") is None
    (tmp_path / "short.jpg").write_bytes(content[:30])
    assert jpeg_of(tmp_path / "short.jpg") is None
    dw.write_image(tmp_path / "a.png", shown().astype(np.float32))
    assert dw.read_image(tmp_path / "a.png").jpeg is None


def test_colour_that_runs_over_the_edge_is_no_misfit(tmp_path):
    """A JPEG of half the resolution of colour. Least squares is off by far more than it says; with the codec known the
    intervals hold.
    """
    random = np.random.default_rng(4)
    write(tmp_path / "a.jpg", shown() + 0.003 * random.normal(size=(32, 48, 3)), 90, "4:2:0")
    file = dw.read_image(tmp_path / "a.jpg")
    known = fitting.fit(scene(), file, FREE, start=START)
    plain = fitting.fit(scene(), file.pixels, FREE, start=START)
    assert known.status == "converged" and "JPEG" in known.message
    off = [(known[name].value - value) / known[name].standard_error for name, value in TRUE.items()]
    assert np.max(np.abs(off)) < 3 and all(known[name].standard_error < 0.1 * value for name, value in TRUE.items())
    colour = [f"paint.k_d.{channel}" for channel in "rgb"]
    worst = [max(abs(fit[name].value - TRUE[name]) for name in colour) for fit in (known, plain)]
    assert worst[0] < worst[1] / 2


def test_how_the_samples_of_a_pixel_are_spread_is_found(monkeypatch):
    """8 x 8 points a pixel, of which a fit takes 4 x 4: drawn out, they see the same of all that is smooth."""
    target = shown(8)
    result = fitting.fit(scene(), target, FREE, start=START)
    assert result.sampling == "pixel" and result.status == "converged", result.message
    for name, value in TRUE.items():
        assert result[name].value == pytest.approx(value, rel=1e-4), name
        low, high = result[name].interval_95
        assert low - 1e-6 <= value <= high + 1e-6, name
    # Points that are not drawn out see a duller highlight.
    monkeypatch.setattr("fitting.solving._settling.spread_of", lambda *given: None)
    plain = fitting.fit(scene(), target, FREE, start=START)
    assert abs(plain["paint.phong_exponent"].value - 20) > 10 * abs(result["paint.phong_exponent"].value - 20)
