"""A model as URDF: bodies, joints, `dynamics` (damping and Coulomb friction) and limits.

Source: the URDF joint and inertial elements of the ROS documentation. URDF has no law beyond those.
"""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from gimbal_hil.knowledge.model_exports.account import Account, ExportedModel
from gimbal_hil.knowledge.model_exports.bodies import body_of, direction_of
from sim_backend.model import ENDLESS, AntennaModel, ModelKind

_BODY = ("mass", "cog.x", "cog.y", "cog.z", *(f"inertia.{k}" for k in ("xx", "yy", "zz", "xy", "xz", "yz")))
#: rad/s or m/s: URDF wants a limit of speed where a model states none
_NO_SPEED_LIMIT = 1e3
#: likewise of effort, N m or N
_NO_EFFORT_LIMIT = 1e6


def urdf_of(model: AntennaModel) -> ExportedModel:
    """A robot of one link for the base and one for each axis; links and joints are named like the axes."""
    parts = ['  <link name="base"/>\n']
    held: set[tuple[str, str]] = set()
    parent = "base"
    for axis in model.axes:
        parts.append(_joint(model, axis, parent) + _link(model, axis))
        held |= {(axis, f"body.{name}") for name in _BODY}
        held |= {(axis, name) for name in ("friction.viscous", "friction.coulomb", "actuator.limit")}
        held |= {(axis, name) for name in ("travel.low", "travel.high") if _ends(model, axis)}
        parent = axis
    text = f'<?xml version="1.0"?>\n<robot name={quoteattr(model.name)}>\n{"".join(parts)}</robot>\n'
    return Account(frozenset(held), {}, {}, "URDF has no place for it").settle(model, text)


def _ends(model: AntennaModel, axis: str) -> tuple[float, float] | None:
    low, high = model.number(axis, "travel.low"), model.number(axis, "travel.high")
    return (low, high) if low > -ENDLESS and high < ENDLESS else None


def _joint(model: AntennaModel, axis: str, parent: str) -> str:
    ends = _ends(model, axis)
    kind = "prismatic" if model.kind is ModelKind.LINEAR else "revolute" if ends else "continuous"
    low, high = ends or (-ENDLESS, ENDLESS)
    effort = model.number(axis, "actuator.limit") or _NO_EFFORT_LIMIT
    span = f' lower="{low:.17g}" upper="{high:.17g}"' if kind != "continuous" else ""
    return (
        f'  <joint name={quoteattr(axis)} type="{kind}">\n'
        f"    <parent link={quoteattr(parent)}/>\n    <child link={quoteattr(axis)}/>\n"
        f'    <axis xyz="{direction_of(model, axis)}"/>\n'
        f'    <limit{span} effort="{effort:.17g}" velocity="{_NO_SPEED_LIMIT:g}"/>\n'
        f'    <dynamics damping="{model.number(axis, "friction.viscous"):.17g}" '
        f'friction="{model.number(axis, "friction.coulomb"):.17g}"/>\n  </joint>\n'
    )


def _link(model: AntennaModel, axis: str) -> str:
    body = body_of(model, axis)
    xx, yy, zz, xy, xz, yz = body.six
    place = " ".join(f"{x:.17g}" for x in body.cog_m)
    return (
        f'  <link name={quoteattr(axis)}>\n    <inertial>\n      <origin xyz="{place}" rpy="0 0 0"/>\n'
        f'      <mass value="{body.mass_kg:.17g}"/>\n'
        f'      <inertia ixx="{xx:.17g}" ixy="{xy:.17g}" ixz="{xz:.17g}" iyy="{yy:.17g}" iyz="{yz:.17g}" '
        f'izz="{zz:.17g}"/>\n    </inertial>\n  </link>\n'
    )
