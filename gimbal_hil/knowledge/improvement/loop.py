"""The loop: survey, diagnose, take over what was named, separate what cannot be told apart, until the model is at the
noise floor.

Every decision rests on all runs so far; a model counts as being at its floor only on a motion that it has not seen
before.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    LEAST_GAP,
    Kind,
    Request,
    Result,
    Verdict,
    attributed,
    corrected_model,
    diagnose,
    recalibrated_model,
    standing,
    verdict_of,
)
from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.knowledge.experiments import Experiment, ProgressSink, Silent, experiment_of_file
from gimbal_hil.knowledge.experiments.sequences import (
    SequenceOptions,
    breakaway_torques,
    build_experiment,
    survey_motion,
)
from gimbal_hil.knowledge.improvement.budgets import AFTERWARDS_S
from gimbal_hil.knowledge.improvement.choosing import (
    Option,
    Pair,
    menu_of,
    open_end,
    pairs_left,
    person_needed,
    question_of,
    reason,
    weighed,
    worth_running,
)
from gimbal_hil.knowledge.improvement.design import DesignTask, made_for
from gimbal_hil.knowledge.improvement.journal import (
    Chosen,
    Diagnosed,
    Ended,
    Entry,
    Journal,
    Measured,
    Measuring,
    Refused,
)
from gimbal_hil.knowledge.improvement.kept import MODEL_FILE, keep_round
from gimbal_hil.knowledge.improvement.learned import learned
from gimbal_hil.knowledge.improvement.measured import measured_table
from gimbal_hil.knowledge.improvement.motion import MADE
from gimbal_hil.knowledge.improvement.rehearsal import Rehearsal, rehearse
from gimbal_hil.knowledge.improvement.site import Site
from gimbal_hil.knowledge.improvement.tables import Role, Tables
from gimbal_hil.knowledge.improvement.task import Ending, Improvement, NextStep, Task, ending_text
from sim_backend.model import AntennaModel, load_model

_BASE_FILE = "base.yaml"


def improve(
    task: Task,
    site: Site,
    journal: Journal,
    *,
    progress: ProgressSink | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Improvement:
    """Improve the model of `task` on the antenna at `site`; what the journal calls done is taken from the folder.

    Raises BadInputError before anything moves when the first survey would exceed a budget, SafetyStopError when a guard
    or the antenna ended an experiment.
    """
    return _Loop(task, site, journal, progress or Silent(), say).run()


class _Loop:
    def __init__(
        self, task: Task, site: Site, journal: Journal, progress: ProgressSink, say: Callable[[str], None]
    ) -> None:
        self.task, self.site, self.journal, self.progress, self.say = task, site, journal, progress, say
        self.past: list[Entry] = list(journal.entries)
        #: the first model with what is known of its numbers by now, without the effects that were added
        self.base = task.start
        self.model, self.data, self.used_s, self.runs = task.start, Tables(), 0.0, 0
        self.diagnoses: list[Diagnosed] = []
        self.separated: list[tuple[str, str]] = []
        #: whether the newest judge is a motion that the present model has not been made with
        self.unseen = False
        #: what the budgets left no room for
        self.left = ""
        #: of the last diagnosis: the menu as it was weighed, what stays open and why, and whether neither run nor
        #: person could tell
        self.considered: list[Json] = []
        self.remarks: list[str] = []
        self.same = True

    # --- the loop itself

    def run(self) -> Improvement:
        """Rounds until an ending."""
        ending = self._first_surveys()
        round_number = 1
        while ending is None:
            diagnosed, choice = self._diagnosed(round_number)
            decision = NextStep(diagnosed.decision)
            if decision is NextStep.AT_THE_FLOOR:
                ending = Ending.AT_THE_FLOOR
            elif decision is NextStep.SUSPECT:
                ending = Ending.SUSPECTED
            elif decision is NextStep.GIVE_UP:
                ending = Ending.AMBIGUOUS if diagnosed.verdict == Kind.AMBIGUOUS.value else Ending.UNEXPLAINED
            elif round_number >= self.task.budgets.rounds:
                ending = Ending.ROUNDS_USED_UP
            else:
                round_number += 1
                ending = None if decision is NextStep.AGAIN else self._next_run(round_number, decision, choice)
        said, more = ending_text(ending, self.diagnoses, self.left)
        self.journal.write(Ended(ending.word, said, self.used_s, round_number, more))
        text = f"{said} {more}".strip()
        self.say(text)
        return Improvement(self.model, ending, text, tuple(self.diagnoses), self.used_s)

    def _first_surveys(self) -> Ending | None:
        for number, role in ((0, Role.SEARCH), (1, Role.JUDGE)):
            refusal = self._measure(
                1,
                self._survey(number),
                role,
                self.task.start.axes,
                "rich motion of both axes, to search on and to judge on",
            )
            if refusal is not None and number == 0:
                raise BadInputError(
                    "the first survey",
                    refusal,
                    "budgets that allow at least two surveys (--short and --survey make them shorter)",
                )
            if refusal is not None:
                return Ending.TIME_USED_UP
        return None

    def _next_run(self, round_number: int, decision: NextStep, choice: Chosen | None) -> Ending | None:
        if decision is NextStep.CHECK:
            experiment, role, axes = self._survey(len(self.data.judge) + 1), Role.JUDGE, list(self.task.start.axes)
            why = "a motion that no model has seen, to check what was taken over"
            refusal = self._measure(round_number, experiment, role, axes, why)
        else:
            assert choice is not None
            experiment = self._separating(choice.sequence, choice.axes, round_number)
            self.separated += [(choice.sequence, axis) for axis in choice.axes]
            role = Role.SHOWN if decision is NextStep.SHOW else Role.SEPARATING
            refusal = self._measure(round_number, experiment, role, choice.axes, choice.why, choice.considered)
        if refusal is None:
            self.unseen = decision is NextStep.CHECK
            return None
        self.left = f"{experiment.name} {refusal}"
        return Ending.TIME_USED_UP

    # --- experiments

    def _survey(self, number: int) -> Experiment:
        return survey_motion(
            SequenceOptions(self.task.settings.rate_hz, every=1, names=self.task.settings.axis_names),
            number,
            self.task.survey_s,
        )

    def _separating(self, sequence: str, axes: Sequence[str], round_number: int = 0) -> Experiment:
        known = breakaway_torques(self.model)
        settings = self.task.settings
        if sequence == MADE:
            return experiment_of_file(self._made(round_number), settings.rate_hz, 1, settings.axis_names)
        options = SequenceOptions(
            settings.rate_hz, tuple(axes), short=True, every=1, breakaway_nm=known, names=settings.axis_names
        )
        return build_experiment(sequence, options)

    def _made(self, round_number: int) -> Path:
        """The plan of a motion that was made for a round."""
        return self.task.out / f"round_{round_number}" / f"{MADE}.yaml"

    def _measure(
        self,
        number: int,
        experiment: Experiment,
        role: Role,
        axes: Sequence[str],
        why: str,
        considered: Sequence[Json] = (),
    ) -> str | None:
        """Run an experiment, or take it from the folder; answers why it was refused, if it was."""
        self.runs += 1
        place = f"round_{number}/{experiment.name}"
        folder, rate = self.task.out / place, self.task.settings.rate_hz
        done = next((e for e in self.past if isinstance(e, Measured) and e.run == place), None)
        if done is None:
            rehearsal = rehearse(experiment, self.task.settings, self.model)
            refusal = self.task.budgets.refusal(experiment, rehearsal, rate, self.used_s)
            if refusal is not None:
                self.journal.write(Refused(number, experiment.name, refusal))
                return refusal
            done = self._conduct(
                number,
                experiment,
                role,
                rehearsal,
                Chosen(number, place, experiment.name, list(axes), why, list(considered)),
            )
        self.used_s = done.antenna_s
        self.data.add(role, measured_table(folder, self.task.start.axes))
        return None

    def _conduct(
        self, number: int, experiment: Experiment, role: Role, rehearsal: Rehearsal, chosen: Chosen
    ) -> Measured:
        rate, began = self.task.settings.rate_hz, time.monotonic()
        self.journal.write(chosen)
        self.say(f"round {number}: {experiment.name} on {' and '.join(chosen.axes)}: {chosen.why}")
        travel = {axis: list(limits) for axis, limits in rehearsal.travel_rad.items()}
        duration_s = experiment.duration_s(rate)
        self.journal.write(
            Measuring(number, chosen.run, experiment.name, duration_s, dict(rehearsal.torque_nm), travel)
        )
        self.site.run(self.task.budgets.guarded(experiment), self.task.out / chosen.run, self.runs, self.progress)
        used = self.used_s + duration_s + AFTERWARDS_S
        done = Measured(number, chosen.run, experiment.name, role.value, used, time.monotonic() - began)
        self.journal.write(done)
        return done

    # --- diagnoses

    def _diagnosed(self, number: int) -> tuple[Diagnosed, Chosen | None]:
        """The diagnosis of a round on all data, made or taken from the journal, with the run that it chose."""
        known = next((e for e in self.past if isinstance(e, Diagnosed) and e.round == number), None)
        if known is not None:
            self.diagnoses.append(known)
            if known.model is not None:
                self.model = load_model(self.task.out / known.model)
            kept_base = self.task.out / f"round_{number}" / _BASE_FILE
            self.base = load_model(kept_base) if kept_base.exists() else self.base
            return known, None if known.choice is None else Chosen(number + 1, "", **known.choice)
        began, self.considered, self.remarks, self.same = time.monotonic(), [], [], True
        if self.unseen:
            self.unseen, gaps = False, standing(self.model, self.data.judge[-1])
            if max(gap["before"] / gap["noise_floor"] for gap in gaps) <= LEAST_GAP:
                text = "What was taken over explains a motion that it had not seen to its noise."
                kind, took_s = "no_discrepancy", time.monotonic() - began
                step = NextStep.AT_THE_FLOOR.value
                as_kept = [dict(gap) for gap in gaps]
                one = Diagnosed(number, kind, text, as_kept, [], [], step, None, [], "", None, took_s)
                return self._noted(one), None
        diagnosis = self._searched(number)
        found = verdict_of(diagnosis)
        verdict = found.document
        model, choice, base = None, None, learned(self.base, found)
        if base is not self.base and self._worth_another_search(found):
            decision = NextStep.AGAIN
        else:
            decision, model, choice = self._decide(number, diagnosis, found)
        if model is not None:
            if diagnosis.model is self.base:
                base = learned(attributed(self.base, recalibrated_model(diagnosis)), found)
            model = attributed(diagnosis.model, model, found)
        remark = "" if choice is not None else " ".join(self.remarks)
        place = self._keep(number, diagnosis, found, model)
        kept = ("sequence", "axes", "why", "considered")
        run = None if choice is None else {key: getattr(choice, key) for key in kept}
        one = Diagnosed(
            number,
            verdict["verdict"],
            found.said.answer,
            verdict["gaps"],
            verdict["effects"],
            verdict["alternatives"],
            decision.value,
            run,
            self.considered,
            remark,
            place,
            time.monotonic() - began,
            " ".join(part for part in (found.said.grounds, found.said.against) if part),
            list(found.would_not_show) if found.kind is Kind.CANNOT_JUDGE else [],
        )
        self.model, self.base = self.model if model is None else model, base
        (self.task.out / f"round_{number}" / _BASE_FILE).write_text(base.to_yaml(), encoding="utf-8")
        return self._noted(one), choice

    def _worth_another_search(self, found: Verdict) -> bool:
        """Whether what was just learned of some numbers may be what the rest hangs on; once for the same runs."""
        is_left = max(gap.after / gap.noise_floor for gap in found.gaps) > LEAST_GAP
        return is_left and not (self.diagnoses and self.diagnoses[-1].decision == NextStep.AGAIN.value)

    def _noted(self, one: Diagnosed) -> Diagnosed:
        self.journal.write(one)
        self.say(f"round {one.round}: {_words(one.verdict)}: {one.text} {one.more}".strip())
        self.diagnoses.append(one)
        return one

    def _searched(self, number: int) -> Result:
        """A search on all data for all that the first model lacks beside what is known of its numbers, so that effects
        which were taken over too early are found again together with the rest.

        Where that explains nothing, a search for what the model as it is now still lacks.
        """

        def from_model(model: AntennaModel) -> Result:
            self.progress.begin(f"round {number}: diagnosis", 1.0, 0.0)
            request = Request(model, tuple(self.data.searched()), tuple(self.data.held_out()))
            return diagnose(request, workers=self.task.workers, dask=self.task.dask, progress=self._tell)

        found = from_model(self.base)
        if _settled(found) or self.model.document == self.base.document:
            return found
        further = from_model(self.model)
        return further if _settled(further) else found

    def _decide(
        self, number: int, diagnosis: Result, verdict: Verdict
    ) -> tuple[NextStep, AntennaModel | None, Chosen | None]:
        """What to do next, the model to go on with where it changed, and the separating run where one is needed."""
        untouched = max(gap.before / gap.noise_floor for gap in verdict.gaps)
        if max(untouched, float(np.max(diagnosis.stated.left()))) <= LEAST_GAP:
            return NextStep.AT_THE_FLOOR, diagnosis.model, None
        if verdict.kind in (Kind.NO_DISCREPANCY, Kind.CANNOT_JUDGE):
            moved = recalibrated_model(diagnosis) if verdict.recalibrated else None
            return (NextStep.AT_THE_FLOOR, diagnosis.model, None) if moved is None else (NextStep.CHECK, moved, None)
        corrected = corrected_model(diagnosis)
        if verdict.kind is Kind.NAMED:
            return NextStep.CHECK, corrected, None
        ambiguous = verdict.kind is Kind.AMBIGUOUS
        pairs = pairs_left(diagnosis, self.diagnoses)
        for pair in pairs:
            choice = self._choice(number, diagnosis, pair, verdict)
            if choice is not None:
                return NextStep.SHOW if pair.against_chance else NextStep.SEPARATE, None, choice
        if any(pair.against_chance for pair in pairs):
            return NextStep.SUSPECT, corrected, None
        # where neither a run of the antenna's own nor a person could tell, the two are the same for every purpose
        return (NextStep.CHECK if ambiguous and self.same else NextStep.GIVE_UP), corrected, None

    def _choice(self, number: int, diagnosis: Result, pair: Pair, verdict: Verdict) -> Chosen | None:
        """The run that a pair asks for, among those that the budgets allow; None, with a remark, where none is worth
        its time.
        """
        self.progress.begin(f"round {number}: which run separates", 1.0, 0.0)
        refused: list[str] = []

        def rehearsed(option: Option, model: AntennaModel) -> SignalsTable | None:
            self.progress.at(f"{option.sequence} on {option.axis}, rehearsed", 0.0)
            experiment = self._separating(option.sequence, [option.axis])
            table = None
            # it will be run on the model as it is: that must be allowed as well
            for one in (self.model, model):
                rehearsal = rehearse(experiment, self.task.settings, one)
                refusal = self.task.budgets.refusal(experiment, rehearsal, self.task.settings.rate_hz, self.used_s)
                if refusal is not None:
                    self.journal.write(Refused(number, option.sequence, refusal))
                    refused.append(f"{option.sequence} on {option.axis} {refusal}")
                    return None
                table = rehearsal.table
            return table

        options = weighed(diagnosis, pair, menu_of(pair, self.separated), rehearsed)
        made = self._made_for(number, diagnosis, pair) if verdict.kind is Kind.AMBIGUOUS else None
        if made is not None and any(made.per_second <= option.per_second for option in options):
            made = None
        options = options if made is None else [made, *options]
        considered = [option.as_considered() for option in options]
        self.considered = considered or self.considered
        best = made or worth_running(pair, options)
        if best is None:
            if verdict.kind is Kind.AMBIGUOUS:
                self.same = self.same and bool(options) and person_needed(pair) is None
                self.remarks.append(
                    open_end(pair, options, refused, max(gap.after / gap.noise_floor for gap in verdict.gaps))
                )
            return None
        return Chosen(number + 1, "", best.sequence, [best.axis], reason(pair, best), considered)

    def _made_for(self, number: int, diagnosis: Result, pair: Pair) -> Option | None:
        """A motion made for a pair, once for each axis."""
        if (MADE, pair.names[0][1]) in self.separated:
            return None
        task = DesignTask(question_of(diagnosis, pair), self.task.settings, self.task.budgets, self.used_s)
        with open_executor(self.task.workers, self.task.dask) as executor:
            return made_for(task, pair, self.model, self._made(number + 1), executor, self._tell)

    def _tell(self, text: str) -> None:
        self.progress.at(text, 0.0)

    def _keep(self, number: int, diagnosis: Result, verdict: Verdict, model: AntennaModel | None) -> str | None:
        sources = [table.source for table in (*self.data.searched(), *self.data.held_out())]
        keep_round(self.task.out / f"round_{number}", diagnosis, verdict, model, sources)
        return None if model is None else f"round_{number}/{MODEL_FILE}"


def _settled(result: Result) -> bool:
    """Whether a search ended with an answer."""
    return result.decision.kind not in (Kind.UNEXPLAINED, Kind.DESCRIBED)


def _words(name: str) -> str:
    return name.replace("_", " ")
