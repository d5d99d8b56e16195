"""What a camera blurs: a thin lens, and a shutter that is open for a while (Cook, Porter and Carpenter 1984; Hearn and
Baker, figures 14-80 and 14-81).
"""

from jaxtyping import Array, Float

from ..._errors import SceneError
from ...geometry import Ray
from ...numerics._safe import normalise
from ...numerics._vector import Vec3, dot
from ...records import Row

BLUR_SAMPLES = 16
"""Where a camera that blurs does not say."""
MOST_BLUR_SAMPLES = 4096
LENS: tuple[Row, ...] = (
    Row("aperture", "number", "Diameter of the lens, metres; 0 is a pinhole. Needs focus.", unit="m", default=None,
        lowest=0, scale="log", moves="rays", blurs=True,
        source="Cook et al. 1984, 3.3"),
    Row("focus", "number", "Distance along the axis at which what is seen is sharp, metres.", unit="m", default=None,
        lowest=0, excluded=True, scale="log", moves="rays", blurs=True,
        source="Cook et al. 1984, 3.3"),
    Row("shutter", "number", "Seconds that the shutter is open, half of them before the time at which the scene is as "
        "stated, and half after.", unit="s", default=None, lowest=0, scale="log", moves="rays", blurs=True,
        source="Cook et al. 1984, 3.5"),
    Row("velocity", "vector", "Of the camera, metres a second.", unit="m/s", default=None, scale="unbounded",
        moves="rays"),
    Row("blur_samples", "count", f"Trees a pixel over which lens and shutter are averaged, at the least; "
        f"{BLUR_SAMPLES} unless stated.", default=None, lowest=1, highest=MOST_BLUR_SAMPLES),
)  # fmt: skip
"""The rows of a camera that may blur."""


def check_lens(aperture, focus, place: str) -> None:
    """Raise `SceneError` where one of the two is stated without the other."""
    if (aperture is None) != (focus is None):
        stated, missing = ("focus", "aperture") if aperture is None else ("aperture", "focus")
        raise SceneError(
            f"{place}: {stated} is stated without {missing}; allowed are both (aperture, the diameter of the lens, and "
            "focus, the distance along the axis that is sharp, in metres) or neither, a pinhole"
        )


def through_lens(
    ray: Ray,
    axes: tuple[Vec3, Vec3, Vec3],
    aperture: Float[Array, ""],
    focus: Float[Array, ""],
    point: tuple[Float[Array, "*n"], Float[Array, "*n"]],
) -> Ray:
    """The rays that leave a thin lens at a point of it and meet, at the distance `focus` along the axis, the rays of
    the pinhole:

        origin = o + a,  direction = (focus / (d.ahead)) d - a, made of unit length,  a = aperture/2 (u right + v top)

    `axes`: unit vectors ahead, to the right and to the top; `point` = (u, v), a place in the unit disc. The point does
    not hang on the numbers, so derivatives in aperture and focus are those of each ray. An aperture of 0 leaves the
    rays as they are.
    """
    ahead, right, top = axes
    aside = right * (point[0] * aperture * 0.5) + top * (point[1] * aperture * 0.5)
    reach = focus / dot(ray.direction, ahead)
    return Ray(ray.origin + aside, normalise(ray.direction * reach - aside))
