"""What contacts are computed from, by shape and by moving body of a MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.physics.engine import BodyDefinition
from simcore.physics.mujoco_model import ModelLayout
from simcore.physics.shape_extent import smallest_thickness
from simcore.physics.shapes import Sphere, bounding_box
from simcore.typing import FloatArray

__all__ = ["ContactMaterials", "materials_of"]

_GIVE = 0.25  # of the smallest extent of a soft body: it is rigid when it is squeezed farther


@dataclass(frozen=True, slots=True, eq=False)
class ContactMaterials:
    """Shape (geoms,) where nothing else is said."""

    friction: FloatArray
    rolling: FloatArray
    """Lever of rolling resistance [m]."""
    restitution: FloatArray
    compliance: FloatArray
    """1 / stiffness [m/N], 0 for rigid surfaces."""
    give: FloatArray
    """How far it can be squeezed before it is rigid [m]."""
    reach: FloatArray
    """Farthest that a body has from its center of mass [m], shape (bodies,); 0 for balls, whose spin moves nothing."""
    inverse_inertia: FloatArray
    """1 / mass three times, then 1 / principal moments, shape (6 bodies,)."""

    def set_body(self, number: int, definition: BodyDefinition) -> None:
        """Take in another mass, center and inertia of a moving body."""
        assert definition.inertia is not None
        self.reach[number] = _reach(definition)
        self.inverse_inertia[6 * number : 6 * number + 3] = 1.0 / definition.mass
        self.inverse_inertia[6 * number + 3 : 6 * number + 6] = 1.0 / np.array(definition.inertia)


def materials_of(definitions: Sequence[BodyDefinition], model: Any, layout: ModelLayout) -> ContactMaterials:
    """Collect them from the bodies of a model."""
    surfaces = [definitions[row].surface for row in layout.row_of_geom]
    moving = [definitions[row] for row in layout.row_of_body]
    give_of_row = np.full(len(definitions), math.inf)
    reach = np.zeros(len(moving))
    for body, one in enumerate(moving):
        reach[body] = _reach(one)
        if one.surface.stiffness is not None:
            give_of_row[layout.row_of_body[body]] = _GIVE * smallest_thickness(one.shape)
    inverse = np.repeat(1.0 / model.body_mass[1:, None], 6, axis=1)
    inverse[:, 3:] = 1.0 / model.body_inertia[1:]
    return ContactMaterials(
        friction=np.array([s.friction for s in surfaces]),
        rolling=np.array([s.rolling for s in surfaces]),
        restitution=np.array([s.restitution for s in surfaces]),
        compliance=np.array([0.0 if s.stiffness is None else 1.0 / s.stiffness for s in surfaces]),
        give=give_of_row[layout.row_of_geom],
        reach=reach,
        inverse_inertia=inverse.ravel(),
    )


def _reach(definition: BodyDefinition) -> float:
    """Farthest corner of a body's bounding box from its center of mass [m]; 0 for balls."""
    if isinstance(definition.shape, Sphere):
        return 0.0
    low, high = bounding_box(definition.shape)
    center = definition.center_of_mass
    return float(np.linalg.norm(np.maximum(np.abs(low - center), np.abs(high - center))))
