"""Rays that Haines' databases take by his protocol, counted with the package's own search, beside published counts.

E. Haines, "A proposal for standard graphics environments", 1987: 513 x 513 eye rays through the corners of 512 x 512
pixels, depth 5, no cutoff. A hit on what mirrors or transmits sends one mirror ray, also at total reflection; one on
what transmits one refracted ray but at total reflection; each hit one shadow ray a light that the surface faces. What
is opaque is seen from its outer side only, the teapot from both.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
from diffwhitted.geometry import NOTHING, Departure, Ray, Shapes, nearest, surface_at
from diffwhitted.numerics._vector import vec3
from diffwhitted.optics import mirrored, refracted
from diffwhitted.scene import numbered_objects, tabulate

from ._figures import Figure
from ._fresh import in_fresh_process, run

KINDS = ("eye", "reflected", "refracted", "shadow")
HAINES = {
    "balls": (263169, 175095, 0, 954368),
    "mount": (173125, 354769, 354769, 412922),
    "tetra": (49788, 0, 0, 46112),
}
"""Eye rays that hit, then the rays of each kind, as published."""
RECOUNT = {
    "balls": (263169, 175057, 0, 954111),
    "mount": (173132, 354770, 354770, 412924),
    "tetra": (49797, 0, 0, 46109),
}
"""By a brute-force counter in double precision."""
AT_MOST = 0.1
"""Percent that a count may differ from the published one."""
CORNERS, DEPTH, BLOCK = 513, 5, 2**16
BOTH_SIDES = ("teapot",)


@dataclass
class Rays:
    """Rays of one level, arrays of one entry a ray."""

    origin: np.ndarray
    direction: np.ndarray
    primitive: np.ndarray
    """The surface that a ray leaves, -1 for none, and whether it does so on the inner side."""
    inwards: np.ndarray

    def __len__(self) -> int:
        return len(self.origin)

    def blocks(self) -> Iterator["Rays"]:
        for first in range(0, len(self), BLOCK):
            yield self.chosen(slice(first, first + BLOCK))

    def chosen(self, which) -> "Rays":
        return Rays(*(getattr(self, key)[which] for key in ("origin", "direction", "primitive", "inwards")))

    def and_then(self, others: "Rays") -> "Rays":
        pairs = ((getattr(self, key), getattr(others, key)) for key in ("origin", "direction", "primitive", "inwards"))
        return Rays(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True)
class Stuff:
    """What the objects of a scene do to rays, one entry an object, and the places of its lights."""

    mirrors: np.ndarray
    transmits: np.ndarray
    index: np.ndarray
    lights: np.ndarray


def count_rays(scene: diffwhitted.Scene, corners: int = CORNERS, depth: int = DEPTH, both_sides: bool = False) -> dict:
    """How many rays of each of `KINDS` a scene takes, by the protocol; `corners` by `corners` eye rays."""
    camera, shapes = scene.cameras["main"].resized(corners - 1, corners - 1), tabulate(scene).shapes
    materials = [scene.materials[thing.material] for thing in numbered_objects(scene)]
    stuff = Stuff(
        np.asarray([np.any(np.asarray(m.values["k_s"]) > 0) for m in materials]),
        np.asarray([np.any(np.asarray(m.values["k_t"]) > 0) for m in materials]),
        np.asarray([m.values["refractive_index"] for m in materials], scene.dtype),
        np.asarray([light.place() for light in scene.lights], scene.dtype),
    )
    row, column = (a.ravel().astype(scene.dtype) for a in np.indices((corners, corners)))
    eye = camera.rays(jnp.asarray(column), jnp.asarray(row))
    nobody = np.full(len(row), NOTHING, np.int32)
    rays = Rays(np.asarray(eye.origin.stacked()), np.asarray(eye.direction.stacked()), nobody, nobody >= 0)
    counts = dict.fromkeys(KINDS, 0)
    for level in range(1, depth + 1):
        following = rays.chosen(slice(0, 0))
        for block in rays.blocks():
            found = _spawned(shapes, stuff, block, both_sides)
            counts["eye"] += found["hits"] if level == 1 else 0
            counts["shadow"] += found["shadow"]
            if level < depth:
                counts["reflected"] += len(found["reflected"])
                counts["refracted"] += len(found["refracted"])
                following = following.and_then(found["reflected"]).and_then(found["refracted"])
        rays = following
    return counts


def _spawned(shapes: Shapes, stuff: Stuff, rays: Rays, both_sides: bool) -> dict:
    """What the rays of a block meet, and what leaves from there."""
    hit = _met(shapes, rays)
    while not both_sides:
        # Go on through what is opaque and seen from within.
        behind = (hit["object"] >= 0) & ~hit["entering"] & ~stuff.transmits[hit["object"]]
        if not behind.any():
            break
        further = Rays(hit["point"], rays.direction, hit["primitive"], np.zeros(len(rays), bool)).chosen(behind)
        beyond = _met(shapes, further)
        for key, values in hit.items():
            values[behind] = beyond[key]
    there = hit["object"] >= 0
    towards = stuff.lights[None] - hit["point"][:, None]
    lit = (towards * hit["normal"][:, None]).sum(axis=-1) > 0
    transmits = there & stuff.transmits[hit["object"]]
    mirrors = there & (stuff.mirrors[hit["object"]] | transmits)
    index = stuff.index[hit["object"]]
    eta = np.where(hit["entering"], 1 / index, index)
    cosine = -(rays.direction * hit["normal"]).sum(axis=-1)
    passes = transmits & (1 - eta**2 * (1 - cosine**2) >= 0)
    bent = _bent(rays.direction, hit["normal"], eta)
    reflected, refracted_ones = (
        Rays(hit["point"], np.asarray(way), hit["primitive"], inwards)
        for way, inwards in zip(bent, (~hit["entering"], hit["entering"]), strict=True)
    )
    return {
        "hits": int(there.sum()),
        "shadow": int(lit[there].sum()),
        "reflected": reflected.chosen(mirrors),
        "refracted": refracted_ones.chosen(passes),
    }


def _met(shapes: Shapes, rays: Rays) -> dict[str, np.ndarray]:
    """The nearest hit of each ray; object -1 where there is none. Blocks are filled up, to share one program."""
    room = BLOCK if len(rays) > 4096 else 4096
    filled = (
        np.concatenate([a, np.repeat(a[:1], room - len(a), axis=0)])
        for a in (rays.origin, rays.direction, rays.primitive, rays.inwards)
    )
    return {key: np.array(value)[: len(rays)] for key, value in _search(shapes, *filled).items()}


@eqx.filter_jit
def _search(shapes: Shapes, origin, direction, primitive, inwards) -> dict:
    ray = Ray(vec3(origin), vec3(direction))
    _, number, crossing = nearest(shapes, ray, Departure(primitive, inwards))
    hit = surface_at(shapes, ray, number, crossing)
    return {
        "object": hit.object,
        "primitive": hit.primitive,
        "entering": hit.entering,
        "point": hit.point.stacked(),
        "normal": hit.shading_normal.stacked(),
    }


@eqx.filter_jit
def _bent(direction, normal, eta):
    """Mirrored and refracted directions."""
    u, n = vec3(direction), vec3(normal)
    return mirrored(u, n).stacked(), refracted(u, n, eta).stacked()


def measure() -> list[Figure]:
    """The three scenes whose counts are published here, each in a fresh process."""
    figures = []
    for name in HAINES:
        ours = in_fresh_process("spd", name)
        for kind, published, recount in zip(KINDS, HAINES[name], RECOUNT[name], strict=True):
            if published:
                figures.append(
                    Figure(
                        f"{name}: {kind} rays off the published count",
                        100 * abs(ours[kind] / published - 1),
                        "%",
                        AT_MOST,
                        f"{ours[kind]:,}; published {published:,}, recount {recount:,}",
                    )
                )
    return figures


def _part(name: str) -> dict:
    jax.config.update("jax_enable_x64", True)
    return count_rays(diffwhitted.standard_scene(name, precision="float64"), both_sides=name in BOTH_SIDES)


if __name__ == "__main__":
    run("spd", measure, _part)
