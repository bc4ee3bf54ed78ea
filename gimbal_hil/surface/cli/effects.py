"""`gimbal-hil effects`: the catalogue of everything that an antenna may have beside its rigid body."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.errors import EXIT_DONE

if TYPE_CHECKING:
    from sim_backend.effects import Effect, Parameter


def command(
    name: Annotated[str | None, typer.Argument(help="One effect only.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="The catalogue as JSON.")] = False,
) -> int:
    """The catalogue of effects by domain: definition, parameters with unit, bounds and neutral value, and the run that
    excites each.
    """
    from gimbal_hil.surface.cli.following import after_effects
    from gimbal_hil.surface.cli.next_line import print_next
    from sim_backend.effects import CATALOGUE, Domain, effect_named

    chosen = list(CATALOGUE.values()) if name is None else [effect_named(name, "gimbal-hil effects")]
    if as_json:
        print(json.dumps({"schema": 1, "effects": [as_document(effect) for effect in chosen]}, indent=1))
        return EXIT_DONE
    for domain in Domain:
        members = sorted((effect for effect in chosen if effect.domain is domain), key=lambda effect: effect.name)
        if members:
            print(domain.name.lower())
            print("\n".join(line for effect in members for line in _lines(effect)))
    if name is None:
        print(
            f"\n{len(chosen)} effects. In a model file:  effects: [{{name: cogging, axis: outer, amplitude: 0.02, "
            f"order: 12}}]"
        )
        print_next(after_effects(None, None))
    else:
        made = [run.sequence for run in chosen[0].separated_by if run.sequence]
        print_next(after_effects(name, made[0] if made else None))
    return EXIT_DONE


def as_document(effect: Effect) -> dict[str, object]:
    """One effect for other tools; `neutral` is null where the number is the model's own and has no value that means
    absent.
    """
    from sim_backend.effects import confused_with

    return {
        "name": effect.name,
        "domain": effect.domain.name.lower(),
        "text": effect.text,
        "equation": effect.equation,
        "source": effect.source,
        "excited_by": effect.excited_by,
        "kind": "number of the model" if effect.is_number else "added physics",
        "hook": effect.hook.name.lower() if effect.hook is not None else None,
        "acts_through": sorted(variable.value for variable in effect.acts_through),
        "needs": [need.text for need in effect.needs],
        "confused_with": list(confused_with(effect.name)),
        "separated_by": [{"run": run.text, "experiment": run.sequence} for run in effect.separated_by],
        "rotary_only": effect.rotary_only,
        "two_axis_only": effect.two_axis_only,
        "parameters": [
            {
                "name": parameter.name,
                "unit": parameter.unit,
                "linear_unit": parameter.linear_unit or parameter.unit,
                "low": parameter.low,
                "high": parameter.high,
                "neutral": None if effect.is_number else parameter.neutral,
                "periodic": parameter.periodic,
                "model_number": parameter.path,
                "text": parameter.text,
            }
            for parameter in effect.parameters
        ],
    }


def _lines(effect: Effect) -> list[str]:
    where = " (two axes only)" if effect.two_axis_only else (" (rotary axes only)" if effect.rotary_only else "")
    lines = [f"  {effect.name:<28}{effect.text}{where}", f"      {effect.equation}"]
    lines += [_parameter_line(effect, parameter) for parameter in effect.parameters]
    lines += [f"      acts through: {', '.join(sorted(variable.value for variable in effect.acts_through))}"]
    lines += [f"      needs: {', '.join(need.text for need in effect.needs)}"] if effect.needs else []
    lines += [f"      separated from what looks alike by: {run.text}" for run in effect.separated_by]
    return lines + [f"      excited by: {effect.excited_by}", f"      source: {effect.source}"]


def _parameter_line(effect: Effect, parameter: Parameter) -> str:
    unit = parameter.unit + (f" ({parameter.linear_unit} linear)" if parameter.linear_unit else "")
    absent = f"the model's {parameter.path}" if effect.is_number else f"neutral {parameter.neutral:g}"
    return f"      {parameter.name:<24}{unit:<30}{parameter.low:g} .. {parameter.high:g}, {absent}: {parameter.text}"
