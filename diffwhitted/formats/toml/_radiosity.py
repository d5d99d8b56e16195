"""The table of light between surfaces in [scene]."""

from pydantic import BaseModel, Field

from ...interreflection import MOST_PATCHES, Solver
from ...scene import Interreflection
from ._keys import KEYS


class RadiosityTable(BaseModel):
    """Light between diffuse surfaces, in place of the ambient light (Hearn and Baker 14-7)."""

    model_config = KEYS

    patches: int = Field(
        Interreflection.patches, json_schema_extra={"minimum": 1, "maximum": MOST_PATCHES},
        description="About so many patches, into which surfaces are cut.",
    )  # fmt: skip
    solver: Solver = Field(
        "progressive", description="direct (LU), gauss-seidel, or progressive refinement; the answer is the same."
    )

    def as_read(self) -> Interreflection | None:
        """The record; raises `SceneError`."""
        return Interreflection.read(self.model_dump())


def plain_radiosity(radiosity: Interreflection | None) -> dict | None:
    """As files have it."""
    return None if radiosity is None else {"patches": radiosity.patches, "solver": radiosity.solver}
