"""How much light a ray can bring at most, by the object that it leaves and the side on which it does.

    out(o) = max(background, hit(p) for p that a ray from the outside of o may meet next)
    hit(p) = local(p) + k_s out(p) + k_t in(p) from outside,  local(p) + k_s in(p) + k_t out(p) from inside,

from 0 upwards, level by level, so that after n rounds no tree of n levels is brighter. `local` is all that ambient
light and lamps can do. A convex surface that a ray leaves is not what it meets next unless the ray is inside of
it, and what lies apart from a solid is never met from within it. Where total internal reflection is
possible the reflected side may pass on everything in place of k_s and k_t. From outside a sphere that stands alone it
is not: a ray that was refracted into it meets its surface at the same angle from within.

Where the weights hang on the angle (Fresnel), those of each angle are a mean of two pairs in place of (k_s, k_t): the
sum of both branches is at most the larger of what the pairs bring. What glass absorbs is not taken off.
"""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from ..numerics._vector import vec3
from ..scene import DEEPEST, AbstractCamera, Scene, most_ambient, numbered_objects
from ..shapes import AbstractObject
from ..tree import Beyond, Passed, Plan, effect_rows

MOST_EXTREMES = 2
"""So many pairs of weights a material has."""
MOST_PAIRS = 2048
"""Of more objects than that, it is not asked which pairs lie apart: any may meet any."""


def most_beyond(scene: Scene, camera: AbstractCamera, plan: Plan) -> Beyond:
    """The most light that can come along a ray that leaves each object, for the tracer; infinite past the largest
    number of its precision.
    """
    with np.errstate(over="ignore"):
        return Beyond(*(vec3(jnp.asarray(side.astype(scene.dtype))) for side in radiance_bounds(scene, camera, plan)))


def radiance_bounds(scene: Scene, camera: AbstractCamera, plan: Plan) -> np.ndarray:
    """Most radiance that comes along a ray that leaves each object, outwards and inwards: (2, objects, 3), linear RGB.

    Of trees of up to `DEEPEST` levels. Infinite where a kind of light, texture, background or effect states no bound,
    and where anything moves: what lies apart now may touch then.
    """
    objects = numbered_objects(scene)
    left = _most_left(scene, plan)
    unknown = (row.weighs is not None and row.extremes is None and row.name in plan.effects for row in effect_rows())
    if not np.isfinite(left) or any(unknown) or plan.effects.motion:
        return np.full((2, len(objects), 3), np.inf)
    background = np.asarray(scene.background.brightest())
    # Bound what each object sends back itself, seen from outside and from within, and what its branches pass on.
    bodies = _Bodies.of(objects)
    by_material = {name: _Material.of(scene, name, plan) for name in {thing.material for thing in objects}}
    made_of = [by_material[thing.material] for thing in objects]
    local, ambient, all_of_it = (
        left * np.stack([getattr(m, field) for m in made_of]) for field in ("local", "ambient", "total")
    )
    # For each pair of weights that a material may have, that of the mirror ray and that of the transmitted one.
    pairs = [left * np.stack([np.stack(m.pairs[k]) for m in made_of], 1) for k in range(MOST_EXTREMES)]
    k_t = np.max([through for _, through in pairs], axis=0)
    dark = bodies.convex & (scene.shadows == "opaque")
    for light in scene.lights:
        dark = dark & bodies.outside_of(light)
    within = np.where(dark[:, None], ambient, local)
    # Find what a ray may meet next, and where total internal reflection is possible.
    near, others = bodies.near(), ~np.diag(bodies.once)
    alone = bodies.round & ~(near & others).any(axis=1) & ~bodies.holding(*camera.starts())
    everything = plan.effects.total_internal_reflection and plan.total_reflection_is_full
    total = np.where((everything & k_t.any(axis=1) & ~alone)[:, None], all_of_it, 0)
    # Let the bounds grow level by level.
    solid, out, into = bodies.convex, np.zeros_like(local), np.zeros_like(local)
    with np.errstate(invalid="ignore"):
        for _ in range(DEEPEST):
            from_outside = local + np.maximum(_split(pairs, out, into), _passed(total, out))
            from_inside = within + np.maximum(_split(pairs, into, out), _passed(total, into))
            either = np.maximum(from_outside, from_inside)
            met = np.where((near | ~solid[None])[..., None], either[None], from_outside[None])
            outwards = np.maximum(background, _most(met, others))
            inside = np.maximum(from_inside, _most(met, others & near))
            out, into = outwards, np.where(solid[:, None], inside, outwards)
    return np.stack([out, into])


def _most_left(scene: Scene, plan: Plan) -> float:
    """The most that effects leave of light on the way from one surface to the next."""
    left = 1.0
    for row in effect_rows():
        if row.dims is not None and row.name in plan.effects:
            left *= np.inf if row.dims_to is None else row.dims_to(scene)
    return left


def _passed(weight: np.ndarray, light: np.ndarray | float) -> np.ndarray:
    """What a branch brings at most; nothing where it weighs nothing, be the light infinite."""
    return np.where(weight > 0, weight * light, 0.0)


def _split(pairs, back: np.ndarray, on: np.ndarray) -> np.ndarray:
    """What both branches bring at most, of the pair of weights that brings most."""
    return np.max([_passed(mirrored, back) + _passed(through, on) for mirrored, through in pairs], axis=0)


def _most(met: np.ndarray, possible: np.ndarray) -> np.ndarray:
    """The brightest of what may be met, by the object that the ray leaves."""
    return np.where(possible[..., None], met, 0).max(axis=1, initial=0)


@dataclass(frozen=True)
class _Material:
    """The most of what a material does, (3,) each."""

    local: np.ndarray
    """Light of its own: ambient light, lamps, and what effects add."""
    ambient: np.ndarray
    """The same without lamps."""
    pairs: tuple[Passed, ...]
    """Weights of the mirror ray and of the transmitted one, of which those of each angle are a mean."""
    total: np.ndarray
    """What total internal reflection carries."""

    @classmethod
    def of(cls, scene: Scene, name: str, plan: Plan) -> "_Material":
        m = scene.materials[name]

        def most(coefficient: str) -> np.ndarray:
            value = np.broadcast_to(np.asarray(m.at_work(coefficient), np.float64), 3)
            worn = m.texture_at_work(coefficient)
            return _passed(value, 1.0 if worn is None else scene.textures[worn].brightest())

        added = [
            np.full(3, np.inf) if row.brightest is None else row.brightest(scene, name)
            for row in effect_rows()
            if row.adds is not None and row.name in plan.effects
        ]
        lamps = sum((light.brightest() for light in scene.lights), np.zeros(3))
        at_most = {name: most(name) for name in ("k_a", "k_d", "k_h", "k_s", "k_t")}
        for row in effect_rows():
            if row.name in plan.effects:
                at_most = row.most(scene, name, at_most)
        ambient = _passed(at_most["k_a"], np.asarray(most_ambient(scene.ambient), np.float64)) + sum(added, np.zeros(3))
        back = at_most["k_d"] + (0.0 if m.highlight == "off" else at_most["k_h"])
        # Find how the branches are weighed, and what total reflection carries.
        k_s, k_t = at_most["k_s"], at_most["k_t"]
        pairs, total = ((k_s, k_t),) * MOST_EXTREMES, np.ones(3)
        for row in effect_rows():
            if row.extremes is not None and row.extremes[0] == m.fresnel_model and row.name in plan.effects:
                pairs, total = row.extremes[1](k_s, k_t), np.maximum(k_s + k_t - k_s * k_t, 0)
        return cls(ambient + _passed(back, lamps), ambient, pairs, total)


@dataclass(frozen=True)
class _Bodies:
    """Where objects are, as far as their bounding spheres tell."""

    objects: tuple[AbstractObject, ...]
    middle: np.ndarray
    """(objects, 3)."""
    radius: np.ndarray
    """Of the bounding spheres; infinite for what has no end."""
    convex: np.ndarray
    """Convex bodies with an end: a ray within meets only what touches them."""
    once: np.ndarray
    """What is convex: a ray that leaves it outwards does not meet it again."""
    round: np.ndarray
    """Their bounding spheres themselves."""
    planes: tuple[int, ...]
    """Those that are half spaces."""

    @classmethod
    def of(cls, objects: tuple[AbstractObject, ...]) -> "_Bodies":
        balls = [thing.ball() for thing in objects]
        radius = np.asarray([r for _, r in balls])
        once = np.asarray([thing.is_convex() for thing in objects], bool)
        solid = once & np.asarray([thing.solid for thing in objects], bool)
        return cls(
            objects,
            np.stack([m for m, _ in balls]) if balls else np.zeros((0, 3)),
            radius,
            solid & np.isfinite(radius),
            once,
            np.asarray([kind.ROUND for kind in map(type, objects)], bool),
            tuple(k for k, thing in enumerate(objects) if thing.half_space() is not None),
        )

    def holding(self, place: np.ndarray, radius: float = 0.0) -> np.ndarray:
        """May a point, or some point of a ball around it, lie inside each body, or on it?"""
        return ~(np.linalg.norm(self.middle - place, axis=1) > self.radius + radius)

    def outside_of(self, light) -> np.ndarray:
        """Is it certain that a light stands outside of each body?"""
        if light.outside:
            return np.ones(len(self.objects), bool)
        place = light.place()
        return np.zeros(len(self.objects), bool) if place is None else ~self.holding(place)

    def near(self) -> np.ndarray:
        """May part of one of two objects lie inside the other?"""
        count = len(self.objects)
        if count > MOST_PAIRS:
            return np.ones((count, count), bool)
        known = self.convex[:, None] & self.convex[None]
        apart = np.linalg.norm(self.middle[:, None] - self.middle[None], axis=-1)
        near = ~(known & (apart >= self.radius[:, None] + self.radius[None]))
        for k in self.planes:
            normal, offset = self.objects[k].half_space() or (np.zeros(3), 0.0)
            beyond = self.convex & (self.middle @ normal - offset >= self.radius)
            near[k, beyond] = near[beyond, k] = False
        return near
