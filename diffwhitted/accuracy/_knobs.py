"""What trades accuracy for time when a scene is rendered: one table, and a choice of its values.

A knob is one field of `Settings`: its row of the table stands beside it.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

from .._errors import SceneError
from ..records import changed
from ..scene import DEEPEST, MOST_BLUR_SAMPLES, MOST_ROUGHNESS_SAMPLES, MOST_SAMPLES, Scene, whole_number
from ..shapes import SHADING
from ._checked import (
    STATED,
    checked_antialias,
    checked_cutoff,
    checked_footprint,
    checked_fresnel,
    checked_precision,
    checked_shading,
)
from ._lamps import with_light_samples
from ._materials import BOTH, with_materials

EXCLUSIVE = ("pixel",)
"""Groups of which one knob at most is turned on."""


@dataclass(frozen=True)
class Knob:
    """A row of the table.

    The knobs of a group do related work: of "pixel" (where a pixel is sampled) one at most is on, those of "tree"
    (how far a ray is followed) go together, and every choice of one group goes with every choice of the other.
    """

    name: str
    costs: str
    controls: str
    """Which error it makes smaller."""
    default: Any
    off: Any
    """The value at which it does nothing."""
    sweep: tuple
    group: str
    text: str
    """How a setting reads: "depth {}"."""
    argument: str | None
    """Of `diffwhitted.render`; None for what belongs to the scene."""
    check: Callable[[Any], Any] = field(repr=False)


def _row(default: Any, **columns: Any) -> Any:
    """A field of `Settings` with its row of the table."""
    return field(default=default, metadata={"row": {"default": default, **columns}})


@dataclass(frozen=True)
class Settings:
    """A value for each knob. Raises `SceneError` for a value that is none, and for two ways to sample a pixel at
    once.
    """

    depth: int = _row(
        5,
        costs="rays: every level more follows the reflected and refracted rays of the one before",
        off=DEEPEST,
        controls="light that arrives over more mirrors and glass than the depth",
        sweep=(1, 2, 3, 4, 5, 6, 8, 12, 16),
        group="tree",
        text="depth {}",
        argument="max_depth",
        check=lambda v: whole_number(v, "depth", highest=DEEPEST),
    )
    cutoff: float = _row(
        0.0,
        costs="rays: a smaller cutoff follows fainter branches",
        off=0.0,
        controls="light of the branches that carry less than the cutoff",
        sweep=(0.0, 1 / 1024, 1 / 256, 1 / 64, 1 / 16),
        group="tree",
        text="cutoff {:.2g}",
        argument="cutoff",
        check=checked_cutoff,
    )
    samples: int = _row(
        1,
        costs="time in proportion to n x n points a pixel",
        off=1,
        controls="edges and textures that a pixel sees in part; falls slowly",
        sweep=(1, 2, 3, 4, 6, 8),
        group="pixel",
        text="{0} x {0} points",
        argument="samples",
        check=lambda v: whole_number(v, "samples"),
    )
    footprint: int = _row(
        0,
        costs="about 4 times a point for one tree, and k x k times that",
        off=0,
        controls="edges and textures that a pixel sees in part; what is left is the curvature within a tree",
        sweep=(0, 1, 2),
        group="pixel",
        text="footprint {}",
        argument="footprint",
        check=checked_footprint,
    )
    antialias: float = _row(
        0.0,
        costs="time: a smaller threshold divides more pixels",
        off=0.0,
        controls="edges and textures of points, where the corners of a pixel differ by more than the threshold",
        sweep=(0.3, 0.1, 0.03),
        group="pixel",
        text="antialias {:.2g}",
        argument="antialias",
        check=checked_antialias,
    )
    light_samples: int | None = _row(
        None,
        costs="time in proportion to the points, each with its shadow rays",
        off=None,
        controls="half shadows of lamps with a size: 0 is one ray to a ball and outlines beside it, n are n points; "
        "None is what the scene says",
        sweep=(0, 4, 16, 64),
        group="light",
        text="light samples {}",
        argument=None,
        check=lambda v: v if v is None else whole_number(v, "light_samples", lowest=0, highest=MOST_SAMPLES),
    )
    fresnel: str | None = _row(
        None,
        costs="a few operations a ray: exact takes two roots more than schlick",
        off=None,
        controls="the weights of mirror rays and transmitted ones of dielectrics; the reference is exact; None is what "
        "the scene says",
        sweep=BOTH[::-1],
        group="fresnel",
        text="fresnel {}",
        argument=None,
        check=checked_fresnel,
    )
    roughness_samples: int | None = _row(
        None,
        costs="time in proportion to the trees, that many a pixel or more",
        off=None,
        controls="noise of reflections in rough surfaces; None is what the scene says",
        sweep=(1, 4, 16, 64),
        group="gloss",
        text="roughness samples {}",
        argument=None,
        check=lambda v: v if v is None else whole_number(v, "roughness_samples", highest=MOST_ROUGHNESS_SAMPLES),
    )
    blur_samples: int | None = _row(
        None,
        costs="time in proportion to the trees, that many a pixel or more",
        off=None,
        controls="noise of what a lens or motion blurs; None is what the camera says",
        sweep=(1, 4, 16, 64),
        group="blur",
        text="blur samples {}",
        argument=None,
        check=lambda v: v if v is None else whole_number(v, "blur_samples", highest=MOST_BLUR_SAMPLES),
    )
    precision: str = _row(
        "float32",
        costs="memory and time, up to twice",
        off="float32",
        controls="rounding, far below the other errors of a picture",
        sweep=("float32", "float64"),
        group="arithmetic",
        text="{}",
        argument=None,
        check=checked_precision,
    )
    shading: str = _row(
        STATED,
        costs="time at each point of a mesh that is not flat; what it costs is measured, not known beforehand",
        off=STATED,
        controls="the light of lamps between the vertices of meshes that are not flat; the reference is phong",
        sweep=SHADING,
        group="mesh",
        text="shading {}",
        argument=None,
        check=checked_shading,
    )

    def __post_init__(self):
        for knob in KNOBS:
            object.__setattr__(self, knob.name, knob.check(getattr(self, knob.name)))
        for group in EXCLUSIVE:
            on = [f"{knob.name} = {self[knob]}" for knob in KNOBS if knob.group == group and self[knob] != knob.off]
            if len(on) > 1:
                raise SceneError(f"{' with '.join(on)}; allowed is one of the two")

    def __getitem__(self, knob: Knob) -> Any:
        return getattr(self, knob.name)

    def __str__(self) -> str:
        """Such as "depth 4, footprint 1": the depth, how a pixel is sampled, and what else is on."""
        on = [knob.text.format(self[knob]) for knob in KNOBS if knob.name == "depth" or self[knob] != knob.off]
        plain = all(self[knob] == knob.off for knob in KNOBS if knob.group == "pixel")
        return ", ".join([*on, "1 point"] if plain else on)

    @property
    def way(self) -> str:
        """The knob that says how a pixel is sampled; "samples" where all are off."""
        return next((knob.name for knob in KNOBS if knob.group == "pixel" and self[knob] != knob.off), "samples")

    @classmethod
    def of(cls, scene: Scene) -> "Settings":
        """What `render(scene, camera)` uses."""
        return cls(
            depth=scene.max_depth, cutoff=float(scene.cutoff), footprint=scene.footprint, precision=scene.precision
        )

    @property
    def variant(self) -> tuple[int | None, str, str | None, int | None, int | None]:
        """What makes another scene or camera of the one that is asked for."""
        return self.light_samples, self.shading, self.fresnel, self.roughness_samples, self.blur_samples

    def applied(self, scene: Scene) -> Scene:
        """The scene with its lamps looked at, and its meshes and materials shaded, as these settings say."""
        return with_light_samples(
            with_materials(self.shaded(scene), self.fresnel, self.roughness_samples), self.light_samples
        )

    def shaded(self, scene: Scene) -> Scene:
        """The scene with its meshes shaded as these settings say."""
        if self.shading == STATED:
            return scene
        return changed(scene, objects=tuple(thing.shaded(self.shading) for thing in scene.objects))

    def options(self) -> dict[str, Any]:
        """The arguments of `diffwhitted.render`."""
        return {
            knob.argument: self[knob]
            for knob in KNOBS
            if knob.argument and not (knob.name == "antialias" and not self.antialias)
        }

    def only(self, **values: Any) -> "Settings":
        """These values, and the other knobs of exclusive groups among them off."""
        groups = {knob.group for knob in KNOBS if knob.name in values and knob.group in EXCLUSIVE}
        off = {knob.name: knob.off for knob in KNOBS if knob.group in groups}
        return replace(self, **off | values)

    def alone(self, knob: Knob) -> Iterator["Settings"]:
        """These settings with each value of the sweep of one knob."""
        return (self.only(**{knob.name: value}) for value in knob.sweep)

    def alternatives(self, group: str) -> tuple["Settings", ...]:
        """These settings first, then all others that differ in the knobs of one group."""
        knobs = [knob for knob in KNOBS if knob.group == group]
        if group in EXCLUSIVE:
            found = [other for knob in knobs for other in self.alone(knob)]
        else:
            values = itertools.product(*(dict.fromkeys((self[knob], *knob.sweep)) for knob in knobs))
            found = [
                replace(self, **dict(zip((knob.name for knob in knobs), chosen, strict=True))) for chosen in values
            ]
        return tuple(dict.fromkeys((self, *found)))

    def with_group(self, other: "Settings", group: str) -> "Settings":
        """These settings with the knobs of one group as in `other`."""
        return replace(self, **{knob.name: other[knob] for knob in KNOBS if knob.group == group})


KNOBS: tuple[Knob, ...] = tuple(Knob(f.name, **f.metadata["row"]) for f in fields(Settings))
"""Every knob that trades accuracy for time."""
