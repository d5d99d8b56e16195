"""Make the photographs of this folder from truth.toml: `python examples/photographs/make.py [FOLDER]`.

What happens to light on its way to a file of a camera: it is averaged over the pixel, falls off to the corners of the
lens, is counted in electrons, gets the noise of the amplifier, the sRGB curve, 8 bits and the losses of JPEG.
"""

import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import OpenImageIO as oiio

import diffwhitted
from diffwhitted.image import encode_signal
from diffwhitted.records import changed

HERE = Path(__file__).parent
ELECTRONS, READ, QUALITY = 4000, 0.003, 92


def photograph(scene: diffwhitted.Scene, shot: diffwhitted.Shot, random: np.random.Generator) -> np.ndarray:
    """The 8-bit codes, (height, width, 3), of one shot."""
    lit = changed(scene, lights=tuple(light for light in scene.lights if light.name in shot.lights), shots=())
    camera = scene.cameras["main"]
    light = np.asarray(diffwhitted.render(lit, camera, samples=8))
    down, across = np.indices(light.shape[:2])
    half = 0.5 * np.hypot(camera.width, camera.height)
    places = ((across + 0.5 - camera.width / 2) / half, (down + 0.5 - camera.height / 2) / half)
    across, down = (jnp.asarray(place.ravel(), jnp.float32) for place in places)
    shown = np.asarray(shot.shown(jnp.asarray(light.reshape(-1, 3).T), across, down), np.float64).T.reshape(light.shape)
    counted = random.poisson(np.maximum(shown, 0) * ELECTRONS) / ELECTRONS + READ * random.normal(size=shown.shape)
    return np.rint(255 * np.clip(encode_signal(counted, "srgb"), 0, 1)).astype(np.uint8)


def write(path: Path, codes: np.ndarray) -> None:
    spec = oiio.ImageSpec(codes.shape[1], codes.shape[0], 3, "uint8")
    for name, value in {"CompressionQuality": QUALITY, "oiio:ColorSpace": "sRGB"}.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), spec):
        raise SystemExit(f"{path} cannot be written: {oiio.geterror()}")
    output.write_image(codes)
    output.close()


def main(folder: Path) -> None:
    scene, random = diffwhitted.load_scene(HERE / "truth.toml"), np.random.default_rng(1975)
    for shot in scene.shots:
        write(folder / f"{shot.name}.jpg", photograph(scene, shot, random))
        print(f"wrote {shot.name}.jpg")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else HERE)
