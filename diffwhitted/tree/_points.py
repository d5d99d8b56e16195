"""Where points stand in place of filtered trees: what in a scene knows no footprint."""

import warnings

from .._errors import SceneNote
from ..scene import Scene, check_footprint, texture_names

POINTS = 4
"""So many points along the side of a pixel stand in place of a filtered tree."""


def points_only(scene: Scene) -> str | None:
    """What in the scene states no silhouette or no mean over a footprint, so that points alone are traced; or None."""
    for thing in scene.objects:
        if not thing.FAMILY.FOOTPRINT:
            return f"object {thing.name!r} ({thing.TYPE})"
    used = {thing.material for thing in scene.objects}
    if name := next((name for name in sorted(used) if scene.materials[name].is_rough), None):
        return f"material {name!r} (roughness)"
    if name := next((name for name in sorted(used) if scene.materials[name].is_wrinkled), None):
        return f"material {name!r} ({scene.materials[name].relief[0][0]})"
    worn = {texture for material in scene.materials.values() for _, texture in material.textures}
    plain = (name for name in texture_names(scene) if name in worn and not scene.textures[name].FOOTPRINT)
    return next((f"texture {name!r} ({scene.textures[name].TYPE})" for name in plain), None)


def trees_or_points(scene: Scene, footprint: int) -> tuple[int, int]:
    """Filtered trees along the side of a pixel, or points where something in the scene knows no footprint, with a
    note.
    """
    check_footprint(footprint, "")
    if not footprint or (what := points_only(scene)) is None:
        return footprint, 1
    points = POINTS * footprint
    warnings.warn(
        f"{what} knows points only, so {points} x {points} points a pixel are traced in place of footprint = "
        f"{footprint}",
        SceneNote,
        stacklevel=2,
    )
    return 0, points
