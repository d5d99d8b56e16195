"""What a camera sees first in each pixel: how far away, which way it faces, and which object it is."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from ..geometry import NOTHING, Departure, Shapes, nearest, surface_at
from ..numerics._kept import kept
from ..scene import AbstractCamera, Scene, near, numbered_objects, tabulate

RAYS = 2**18
"""At a time."""


@dataclass(frozen=True, eq=False)
class Layers:
    """What the ray through the middle of each pixel meets first.

    - `depth`: (height, width), distance along the ray in metres, not along the camera's axis; infinite where nothing
      is met.
    - `normal`: (height, width, 3), geometric unit normal in the scene's axes, on the side of the camera; 0 where
      nothing is met.
    - `object`: (height, width), the number of the object: its place in `names`; -1 where nothing is met.
    """

    depth: np.ndarray
    normal: np.ndarray
    object: np.ndarray
    names: tuple[str, ...]

    def of(self, name: str) -> np.ndarray:
        """(height, width), true where the object of that name is met."""
        return self.object == self.names.index(name)

    def channels(self) -> dict[str, np.ndarray]:
        """By the names that an image file has for them, float32: depth.Z, normal.X, .Y and .Z, object.id."""
        normal = {f"normal.{axis}": self.normal[..., k] for k, axis in enumerate("XYZ")}
        return {
            name: np.asarray(channel, np.float32)
            for name, channel in ({"depth.Z": self.depth} | normal | {"object.id": self.object}).items()
        }


def layers(scene: Scene, camera: AbstractCamera) -> Layers:
    """Depth, normal and object of what the ray through the middle of each pixel meets first, whatever it is made of.

    Not for traced values: nothing here has a derivative.
    """
    scene, camera = near(scene, camera)
    names = tuple(thing.name for thing in numbered_objects(scene))
    shapes, pixels = tabulate(scene).shapes, np.arange(camera.width * camera.height)
    room, found = min(RAYS, len(pixels)), []
    for first in range(0, len(pixels), room):
        # The last part is filled up, so that one program serves all.
        some = np.resize(pixels[first : first + room], room)
        part = _first_hits(shapes, camera, jnp.asarray(some, jnp.int32))
        found.append([np.asarray(field)[..., : min(room, len(pixels) - first)] for field in part])
    depth, normal, number = (np.concatenate(fields, axis=-1) for fields in zip(*found, strict=True))
    size = camera.height, camera.width
    return Layers(depth.reshape(size), np.moveaxis(normal.reshape(3, *size), 0, -1), number.reshape(size), names)


@kept
def _first_hits(shapes: Shapes, camera: AbstractCamera, pixel):
    """Depth, normal (3, n) and object of the rays through the middle of these pixels."""
    column, row = camera.place(pixel, jnp.full(2, 0.5, camera.look_from.dtype))
    ray = camera.rays(column, row)
    departure = Departure(jnp.full(pixel.shape, NOTHING, jnp.int32), jnp.zeros(pixel.shape, bool))
    distance, primitive, crossing = nearest(shapes, ray, departure)
    hit = surface_at(shapes, ray, primitive, crossing)
    return distance, hit.normal.stacked(axis=0), hit.object
