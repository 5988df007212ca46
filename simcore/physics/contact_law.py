"""What a contact does within a step: bounce at the time of impact, spring under load, Coulomb friction, rolling.

A solver that takes a reference acceleration `a_ref` and a regularization `r` for each row of a contact minimizes so
that `(A + r) f = a_ref - a_0` where the row is active: `A` is its inverse mass and `a_0` its acceleration without
contacts. Four laws are written in that form:

- Impact. Bodies that meet within the step, faster than `REST_SPEED`, leave with restitution times the speed at which
  they meet (Newton's law), whatever the step and the phase of the hit in it. Rigid ones must be faster than what a push
  gives them in a step: a robot that leans on a wall does not bounce off it in each.
- Touch. Bodies that are apart may come no nearer within the step than to touch.
- Load. Bodies that overlap, and soft ones that touch, push each other apart by a spring and a damper, taken at the end
  of the step (implicit Euler): f = k x - c v. It cannot gain energy at any step.
- Friction. Rows across the normal ask for rest at the end of the step, and get what the friction can give. The cone
  of such a solver is convex, which lifts what slides: by the `excess` of the wish times the friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simcore.typing import BoolArray, FloatArray

__all__ = ["REST_SPEED", "RIGID", "NormalLaw", "excess", "normal_law"]

REST_SPEED = 0.1
"""Slower impacts do not bounce [m/s]; such a bounce would rise 0.5 mm."""
RIGID = 5e6
"""Stiffness of a contact between rigid bodies [N/m]: a robot of 55 kg on four corners sinks by 0.007 mm. With a tenth
of it, a robot that slides pitches on the carpet by so much that its path depends on the step (24 mm in 12 m)."""
_PUSHED = 20.0  # [m/s^2]; twice what tires give a robot, which gets the speed of a step at its start
_RELAXATION = 0.02  # [s]; overlaps of rigid bodies go away with this time constant, so that they give no speed
_HARDNESS = 1e-3  # regularization of an impact, in parts of its inverse mass
_BARELY = 0.0015  # [m]; a contact that overlaps by less can still bounce, one that is squeezed is a spring
_TOUCHING = 1e-4  # [m]; soft bodies that are no farther apart touch
_DEEPEST = 0.01  # [m]; deeper overlaps of rigid bodies push no more: bodies put into each other do not explode

_DEEPEST_GIVE = 3.0  # the same of soft ones, in parts of what they give: three quarters of a ball's diameter


@dataclass(frozen=True, slots=True, eq=False)
class NormalLaw:
    """Rows of normals, one contact a row, shape (n,) each."""

    reference: FloatArray
    """Reference acceleration [m/s^2]."""
    regularization: FloatArray
    """[1/kg]"""
    hits: BoolArray
    """Whether it is an impact."""
    loaded: BoolArray
    """Whether it is a spring under load."""
    hit_time: FloatArray
    """When within the step the impact is [s]; 0 elsewhere."""
    force: FloatArray
    """What the contact will push if it is the only one of its bodies [N]."""


def normal_law(
    gap: FloatArray,
    speed: FloatArray,
    free: FloatArray,
    inverse_mass: FloatArray,
    *,
    restitution: FloatArray,
    stiffness: FloatArray,
    give: FloatArray,
    h: float,
) -> NormalLaw:
    """What the normals of contacts do within a step.

    Args:
        gap: Between the surfaces, negative where they overlap [m], shape (n,).
        speed: Rate of the gap [m/s].
        free: Acceleration of the gap without contacts [m/s^2].
        inverse_mass: Of the normal row [1/kg].
        restitution: Of the pair [-].
        stiffness: Of the pair [N/m], `RIGID` or more for rigid ones.
        give: How far the pair can be squeezed before it is rigid [m].
        h: Step [s].
    """
    # When they meet: gap + speed t + free t^2 / 2 = 0.
    ahead = np.maximum(gap, 0.0)
    meeting = -np.sqrt(np.maximum(speed * speed - 2.0 * free * ahead, 0.0))
    closing = speed + meeting
    hit_time = np.clip(2.0 * ahead / np.maximum(-closing, 1e-9), 0.0, h)
    is_reached = (gap + (speed + 0.5 * free * h) * h < 0.0) & (speed + free * h < 0.0)
    meeting = np.where(gap > 0.0, meeting, speed)
    is_rigid = stiffness >= RIGID
    slowest = np.where(is_rigid, max(REST_SPEED, _PUSHED * h), REST_SPEED)
    hits = is_reached & (meeting < -slowest) & ((gap > -_BARELY) | is_rigid)
    loaded = ~hits & (gap < 0.0)
    # Impact: leave with restitution times the speed of meeting, and fall on for the rest of the step.
    rest = h - hit_time
    leave = np.maximum(-restitution * meeting + free * rest, 0.0)
    hit_reference = free + ((leave - speed) / h - free) * (1.0 + _HARDNESS)
    # Load: f = f0 + k (x - h v') - c v' with the velocity v' at the end of the step.
    # A soft pair that just touches is the same spring, so that nothing hangs on the sign of a gap that is nothing.
    springs = loaded | (~(hits | is_rigid) & (gap < _TOUCHING))
    depth = -gap
    log = np.log(np.maximum(restitution, 1e-3))
    damping_ratio = -log / np.sqrt(np.pi**2 + log**2)
    soft_damping = 2.0 * damping_ratio * np.sqrt(stiffness / inverse_mass)
    is_hard = is_rigid | (depth - np.minimum(speed, 0.0) * h > give)
    k = np.where(is_hard, RIGID, stiffness)
    c = np.where(is_rigid, RIGID * _RELAXATION, soft_damping)
    c[(gap > 0.0) & (speed < -REST_SPEED)] = 0.0  # nothing is slowed before it is there
    is_bottomed = is_hard & ~is_rigid
    preload = np.zeros(len(gap))
    preload[is_bottomed] = (stiffness[is_bottomed] - RIGID) * give[is_bottomed]
    regularization = 1.0 / (h * (k * h + c))
    felt = np.minimum(depth, np.where(is_rigid, _DEEPEST, _DEEPEST_GIVE * give))
    load_reference = (preload + k * felt - (k * h + c) * speed) * regularization
    near_reference = -(ahead / h + speed) / h
    reference = np.where(hits, hit_reference, np.where(springs, load_reference, near_reference))
    regularization = np.where(springs, regularization, _HARDNESS * inverse_mass)
    force = np.maximum((reference - free) / (inverse_mass + regularization), 0.0)
    held = np.where(springs, np.maximum(preload + k * felt, 0.0), 0.0)
    return NormalLaw(
        reference=reference,
        regularization=regularization,
        hits=hits,
        loaded=loaded,
        hit_time=np.where(hits, hit_time, 0.0),
        force=np.maximum(force, held),
    )


def excess(wish: FloatArray, free: FloatArray, limit: FloatArray) -> FloatArray:
    """By how much a wish is beyond what friction can give, shape (n,).

    Args:
        wish: What would end all sliding or rolling within the step, along two axes [m/s^2 or rad/s^2], shape (n, 2).
        free: Acceleration without contacts, shape (n, 2).
        limit: What friction at its limit gives, in all contacts of the bodies, shape (n,).
    """
    size = np.sqrt(np.einsum("ij,ij->i", wish, wish))
    pulled = np.sqrt(np.einsum("ij,ij->i", free, free))
    return np.asarray(np.maximum(size - limit - pulled, 0.0))
