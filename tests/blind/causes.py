"""What can be hidden: every effect of docs/reference/effects.md, numbers that are wrong, and causes that no catalogue
holds.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

Array = np.ndarray
THESIS = {
    "outer": dict(Ts=0.2585, Tc=0.2412, vs=0.0054, s0=238.88, s1=16.02, s2=0.0609, delta=1.0459),
    "inner": dict(Ts=0.1451, Tc=0.1376, vs=0.0075, s0=271.68, s1=6.97, s2=0.0336, delta=1.4628),
}
BODY = {
    "outer": np.array([0.2028, 0.3481, 0.4386, 0.04218, 0.006896, 0.0002447, 0.06356, -0.01475, -0.01767, 14.63]),
    "inner": np.array(
        [0.03047, 0.06959, 0.06420, 0.0004686, 0.0006625, 0.0002815, 0.02084, -0.0009696, 0.007755, 5.08]
    ),
}


@dataclass(frozen=True)
class Cause:
    """One thing that is hidden: its name, axis, and where its numbers live."""

    name: str
    #: "outer" or "inner", whatever the data calls them
    axis: str
    #: column of the axis row, or body index, to absolute value at magnitude scale 1
    row: dict[str, float] = field(default_factory=dict)
    body: dict[int, float] = field(default_factory=dict)
    #: which of the above scale with magnitude
    scaled: tuple[str | int, ...] = ()
    inside: bool = True
    #: whether it shows on a moving base only
    base: bool = False
    #: a number that the model has wrong: of a size that is drawn, not scaled to a magnitude
    number: bool = False
    #: names of the catalogue that say as much of it as a name can
    akin: tuple[str, ...] = ()


def catalogue(rng: Generator, axis: str, kind: int) -> list[Cause]:
    """Every effect of docs/reference/effects.md on this axis, with drawn shapes; magnitudes are scaled afterwards."""
    f = THESIS[axis]
    sign = float(rng.choice([-1.0, 1.0]))
    ph = float(rng.uniform(-np.pi, np.pi))
    out = [
        Cause("viscous", axis, dict(s2=0.1), scaled=("s2",)),
        Cause("coulomb", axis, dict(Tc=0.02 * sign, Ts=0.02 * sign), scaled=("Tc", "Ts")),
        Cause("stribeck", axis, dict(Ts=0.05, vs=f["vs"] * float(rng.uniform(1.5, 4.0))), scaled=("Ts",)),
        Cause("presliding", axis, dict(s0=-0.3 * f["s0"]), scaled=("s0",)),
        Cause("coulomb_asymmetry", axis, dict(asym_c=0.1 * sign), scaled=("asym_c",)),
        Cause("viscous_asymmetry", axis, dict(asym_v=0.3 * sign), scaled=("asym_v",)),
        Cause("load_dependent_friction", axis, dict(load_c=0.05), scaled=("load_c",)),
        Cause(
            "position_dependent_friction",
            axis,
            dict(pos_a=0.1, pos_n=float(rng.integers(1, 13)), pos_ph=ph),
            scaled=("pos_a",),
        ),
        Cause("quadratic_drag", axis, dict(quad=0.05), scaled=("quad",)),
        Cause("temperature_viscosity", axis, dict(temp_b=0.02), scaled=("temp_b",)),
        Cause(
            "inertia",
            axis,
            body={9 if kind == 2 else (2 if axis == "outer" else 1): 0.02 * sign},
            scaled=(9 if kind == 2 else (2 if axis == "outer" else 1),),
        ),
        Cause("cable_spring", axis, dict(spring_k=0.05, spring_q0=float(rng.uniform(-0.5, 0.5))), scaled=("spring_k",)),
        Cause("cogging", axis, dict(cog_a=0.02, cog_n=float(rng.integers(3, 37)), cog_ph=ph), scaled=("cog_a",)),
        Cause(
            "structural_resonance",
            axis,
            dict(res_w=2 * np.pi * float(rng.uniform(9, 28)), res_z=float(rng.uniform(0.01, 0.05)), res_share=0.1),
            scaled=("res_share",),
        ),
        # half of the outer rotors count in the inertia that the model states; the others come on top of it, and then
        # carry the magnitude
        Cause("backlash", axis, dict(gap=2e-3, rotor=0.02 if axis == "inner" else 0.1, play_share=1.0), scaled=("gap",))
        if rng.random() < 0.5 and axis == "outer"
        else Cause(
            "backlash",
            axis,
            dict(gap=float(np.exp(rng.uniform(np.log(5e-4), np.log(4e-3)))), rotor=0.02 if axis == "inner" else 0.1),
            scaled=("rotor",),
        ),
        Cause("torque_gain", axis, dict(gain=0.05 * sign), scaled=("gain",)),
        Cause("torque_offset", axis, dict(offset=0.05 * sign), scaled=("offset",)),
        Cause("actuator_lag", axis, dict(lag=2e-3), scaled=("lag",)),
        Cause("transport_delay", axis, dict(delay=2e-3), scaled=("delay",)),
        Cause("saturation", axis, dict(limit=1.0)),
        Cause("back_emf", axis, dict(emf=0.1), scaled=("emf",)),
    ]
    if kind != 2:
        out += [
            Cause(
                "static_unbalance",
                axis,
                body={6: 0.005 * sign, (7 if axis == "outer" else 8): 0.004},
                scaled=(6, 7 if axis == "outer" else 8),
            ),
            Cause("encoder_eccentricity", axis, dict(ecc_a=1e-3, ecc_ph=ph), scaled=("ecc_a",)),
        ]
    if kind == 0:
        out += [
            Cause("dynamic_unbalance", axis, body={4: 0.02 * sign, 5: 0.015}, scaled=(4, 5), base=True),
            Cause("gyro_bias", axis, dict(g_bias=0.005 * sign), scaled=("g_bias",)),
            Cause("gyro_scale", axis, dict(g_scale=0.01 * sign), scaled=("g_scale",)),
            Cause(
                "gyro_misalignment",
                axis,
                dict(leak_x=0.03 * sign, **({"leak_y": 0.02} if axis == "outer" else {"leak_z": 0.02})),
                scaled=("leak_x", "leak_y" if axis == "outer" else "leak_z"),
                base=True,
            ),
        ]
    return out


def outside(rng: Generator, axis: str) -> list[Cause]:
    """Causes that no catalogue holds."""
    drawn = [
        _strange("position_bump", axis, "bump_a", 0.1, bump_q=float(rng.uniform(-0.3, 0.3)), bump_w=0.06),
        _strange("torque_dead_zone", axis, "dead", 0.05),
        _strange("elastic_hysteresis", axis, "hyst_a", 0.1, ("cable_spring",), hyst_w=float(rng.uniform(0.05, 0.2))),
        _strange("viscous_jump", axis, "jump_s2", 0.2, ("viscous",), jump_t=float(rng.uniform(4, 14))),
        _strange("cross_axis_friction", axis, "cross_c", 0.2),
        _strange("hum_in_time", axis, "sine_a", 0.05, sine_f=float(rng.uniform(0.7, 9.0))),
        _strange("random_field", axis, "field_a", 0.03, field_seed=float(rng.uniform(0, 100))),
    ]
    # a stream of their own, so that what is drawn after them does not depend on how many there are
    return [*drawn, *_outside_since(rng.spawn(1)[0], axis)]


def _outside_since(rng: Generator, axis: str) -> list[Cause]:
    centre = 0.0 if axis == "outer" else 0.4
    ph = float(rng.uniform(-np.pi, np.pi))
    width = float(rng.uniform(0.2, 0.6))
    free = float(rng.uniform(0.3, 0.7) if axis == "outer" else rng.uniform(0.15, 0.3))
    return [
        _strange("hardening_stop", axis, "stop_k", 0.5, stop_q=centre, stop_w=free),
        _strange("hysteretic_cable", axis, "hyst_a", 0.1, ("cable_spring",), hyst_w=width, hyst_n=2.0),
        _strange(
            "worked_grease",
            axis,
            "grease_a",
            0.1,
            grease_tau=float(rng.uniform(3, 12)),
            grease_p=float(rng.uniform(0.05, 0.2)),
        ),
        _strange("dwell_stiction", axis, "dwell_a", 0.02),
        _strange(
            "cable_snag",
            axis,
            "snag_a",
            0.1,
            snag_q=centre + float(rng.uniform(-0.2, 0.2)),
            snag_w=float(rng.uniform(0.02, 0.08)),
        ),
        _strange(
            "slosh",
            axis,
            "slosh_j",
            0.02,
            # a sprung mass that comes on top of the axis' own inertia
            ("structural_resonance", "inertia"),
            slosh_w=2 * np.pi * float(rng.uniform(0.5, 2.0)),
            slosh_z=float(rng.uniform(0.1, 0.4)),
        ),
        _strange("torque_leak", axis, "leak_t", 0.05 * float(rng.choice([-1.0, 1.0]))),
        _strange(
            "encoder_subdivision",
            axis,
            "sub_a",
            5e-5,
            sub_n=float(rng.integers(60, 400)),
            sub_ph=float(rng.uniform(0.3, 1.5)),
        ),
        _strange(
            "position_viscosity",
            axis,
            "visc_a",
            0.3,
            ("position_dependent_friction", "viscous"),
            visc_n=float(rng.integers(1, 9)),
            visc_ph=ph,
        ),
        Cause("torque_dropouts", axis, dict(weather=0.5), scaled=("weather",), inside=False),
        Cause("friction_switching", axis, dict(weather=0.1), scaled=("weather",), inside=False),
    ]


def _strange(name: str, axis: str, scaled: str, size: float, akin: tuple[str, ...] = (), **shape: float) -> Cause:
    return Cause(name, axis, {scaled: size} | shape, scaled=(scaled,), inside=False, akin=akin)


#: numbers of a model that can be wrong by themselves, each under the effect's name that says so
NUMBERS = ("viscous", "coulomb", "inertia", "static_unbalance", "presliding")


def wrong_number(name: str, axis: str, kind: int, change: float, friction: dict[str, float], body: Array) -> Cause:
    """The antenna's number is `change` (relative) off what the model says."""
    own = 9 if kind == 2 else (2 if axis == "outer" or kind else 1)
    if name == "inertia":
        return Cause(name, axis, body={own: change * float(body[own])}, number=True)
    if name == "static_unbalance":
        side = 7 if axis == "outer" else 8
        return Cause(name, axis, body={6: change * float(body[6]), side: change * float(body[side])}, number=True)
    if name == "presliding":
        return Cause(name, axis, {"s0": change * friction["s0"]}, number=True)
    if name == "coulomb":
        return Cause(name, axis, {"Tc": change * friction["Tc"], "Ts": change * friction["Tc"]}, number=True)
    return Cause(name, axis, {"s2": change * friction["s2"]}, number=True)


#: what the simulated antenna resolves (a lag below half a substep is none) and what keeps a scaled quantity physical:
#: multiples of scale 1
LEAST = {"actuator_lag": 0.04}
CAPS = {
    "viscous": 6.0,
    "coulomb": 6.0,
    "stribeck": 3.0,
    "presliding": 2.6,
    "inertia": 5.0,
    "static_unbalance": 4.0,
    "dynamic_unbalance": 1.2,
    "coulomb_asymmetry": 5.0,
    "viscous_asymmetry": 2.8,
    # a joint locks itself at a coefficient of 1, and the catalogue ends at 0.9
    "load_dependent_friction": 16.0,
    "position_dependent_friction": 6.0,
    "structural_resonance": 4.0,
    "backlash": 8.0,
    "actuator_lag": 5.0,
    "transport_delay": 6.0,
    "torque_gain": 5.0,
    "temperature_viscosity": 3.0,
    "encoder_eccentricity": 20.0,
    "torque_dropouts": 2.0,
    "friction_switching": 4.0,
    "position_viscosity": 3.0,
    "dwell_stiction": 6.0,
    "worked_grease": 20.0,
    "slosh": 5.0,
    "torque_leak": 4.0,
}
