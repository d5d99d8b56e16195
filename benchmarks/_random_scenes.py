"""Random scenes of one structure, whose fits share their programs, and the pictures that people have of them."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

import diffwhitted
from diffwhitted.image import encode_signal
from diffwhitted.scene import Scene
from fitting import Target

SIZE = (48, 36)
FREE = ("paint.k_a", "paint.k_d", "paint.k_h", "paint.phong_exponent", "mirror.k_s", "floor.k_d")
START = {
    "paint.k_a": 0.05,
    "paint.k_d": (0.3, 0.3, 0.3),
    "paint.k_h": 0.2,
    "paint.phong_exponent": 20.0,
    "mirror.k_s": 0.4,
    "floor.k_d": 0.4,
}
BRIGHTEST = 0.95
"""Scenes with a brighter pixel are drawn anew: clipped pixels are another matter."""
SCENE = """
[scene]
background = [0.25, 0.3, 0.4]
ambient = [1, 1, 1]
max_depth = 3

[[camera]]
name = "main"
look_from = [0, 1.2, 6]
look_at = [0, 0.4, 0]
vfov_deg = 34
width = {width}
height = {height}

[[light]]
name = "lamp"
type = "point"
position = {lamp}
colour = [0.9, 0.85, 0.8]

[[material]]
name = "paint"
k_a = {k_a}
k_d = {k_d}
k_h = {k_h}
phong_exponent = {phong_exponent}
highlight = "reflected"

[[material]]
name = "mirror"
k_a = 0.03
k_d = 0.15
k_h = 0.2
k_s = {k_s}
phong_exponent = 40
highlight = "reflected"

[[material]]
name = "floor"
k_a = 0.05
k_d = {floor}
highlight = "off"

[[object]]
name = "ball"
type = "sphere"
centre = {ball}
radius = 1
material = "paint"

[[object]]
name = "second"
type = "sphere"
centre = {second}
radius = 0.7
material = "mirror"

[[object]]
name = "ground"
type = "plane"
offset = -0.8
normal = [0, 1, 0]
material = "floor"
"""


def random_scene(random: np.random.Generator) -> tuple[Scene, dict[str, float]]:
    """A scene, and its free numbers by the names that a fit has for them."""

    def draw(low: float, high: float) -> float:
        return round(float(random.uniform(low, high)), 6)

    colour = [draw(0.1, 0.6) for _ in range(3)]
    drawn = {"k_a": draw(0.02, 0.15), "k_h": draw(0.1, 0.3), "phong_exponent": draw(8, 60)}
    k_s, floor = draw(0.2, 0.7), draw(0.2, 0.7)
    text = SCENE.format(
        width=SIZE[0],
        height=SIZE[1],
        lamp=[draw(-4, 4), draw(3, 6), draw(2, 6)],
        ball=[draw(-1.1, -0.8), draw(0.1, 0.4), draw(-0.3, 0.3)],
        second=[draw(1.0, 1.4), draw(-0.1, 0.3), draw(-0.3, 0.5)],
        k_d=colour,
        k_s=k_s,
        floor=floor,
        **drawn,
    )
    truth = {f"paint.{name}": value for name, value in drawn.items()}
    truth |= {f"paint.k_d.{channel}": value for channel, value in zip("rgb", colour, strict=True)}
    return diffwhitted.parse_scene(text), truth | {"mirror.k_s": k_s, "floor.k_d": floor}


def picture_of(scene: Scene, samples: int = 1) -> np.ndarray:
    return np.asarray(diffwhitted.render(scene, scene.cameras["main"], samples=samples), np.float64)


def _stored(picture: np.ndarray, bits: int, kind: str, quality: int = 90):
    """The picture as a file of sRGB codes has it, read back."""
    codes = np.rint(np.clip(encode_signal(picture, "srgb"), 0, 1) * (2**bits - 1))
    codes = codes.astype(np.uint8 if bits == 8 else np.uint16)
    spec = oiio.ImageSpec(codes.shape[1], codes.shape[0], 3, codes.dtype.name)
    spec.attribute("oiio:ColorSpace", "sRGB")
    if kind == "jpg":
        spec.attribute("CompressionQuality", quality)
        spec.attribute("jpeg:subsampling", "4:2:0")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"picture.{kind}")
        output = oiio.ImageOutput.create(str(path))
        assert output is not None and output.open(str(path), spec), "both are built in"
        output.write_image(codes)
        output.close()
        return diffwhitted.read_image(path)


def _noisy(picture: np.ndarray, random: np.random.Generator, sigma: float) -> np.ndarray:
    return picture + random.normal(size=picture.shape) * sigma


def _counted(picture: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Electrons of a camera that counts 500 to 5000 of them at a value of 1, and its read noise."""
    electrons = 10 ** random.uniform(2.7, 3.7)
    return _noisy(random.poisson(np.maximum(picture, 0) * electrons) / electrons, random, 0.002)


def _behind_bars(picture: np.ndarray, random: np.random.Generator) -> Target:
    """Gaussian noise, and bars of something else across a third of the picture, which a mask leaves out."""
    down, across = np.indices(picture.shape[:2])
    angle, width = random.uniform(0, np.pi), random.uniform(5, 12)
    place = (np.cos(angle) * across + np.sin(angle) * down) / width + random.uniform()
    mask = (place % 1 < 0.67).astype(np.float64)
    seen = np.where(mask[..., None] > 0, _noisy(picture, random, 0.01), random.uniform(size=picture.shape))
    return Target(seen, mask=mask)


KINDS: dict[str, Callable] = {
    "8-bit sRGB, no noise": lambda p, r: _stored(p, 8, "png"),
    "8-bit sRGB, noise": lambda p, r: _stored(_noisy(p, r, 10 ** r.uniform(-3.3, -2)), 8, "png"),
    "16-bit sRGB": lambda p, r: _stored(p, 16, "png"),
    "Gaussian noise": lambda p, r: _noisy(p, r, 10 ** r.uniform(-3, -1.5)),
    "Poisson and read noise": _counted,
    "mask": _behind_bars,
    "JPEG, quality 90": lambda p, r: _stored(p, 8, "jpg"),
    "JPEG, quality 90, noise": lambda p, r: _stored(_noisy(p, r, 10 ** r.uniform(-3, -2)), 8, "jpg"),
    "antialiased": lambda p, r: p,
    "antialiased, noise": lambda p, r: _noisy(p, r, 10 ** r.uniform(-3, -1.5)),
}
"""What becomes of a picture: from light and a random generator to the target of a fit."""
SYSTEMATIC = ("JPEG", "antialiased")
"""How the kinds begin whose errors are no noise."""
