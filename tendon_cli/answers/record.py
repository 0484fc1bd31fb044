"""The record of an answer: the best choices and their limits, or the conflicts and what helps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from tendon_cli.answer_record import (
    AnswerResults,
    AssumedRecord,
    BetweenSamples,
    ChecksRecord,
    ChoiceCertificate,
    ChoiceRecord,
    ConflictRecord,
    ListedRecord,
    SensitivityRecord,
    TradeOffRecord,
    Values,
)
from tendon_cli.answers.assumed import (
    drawn_deviations,
    exact_numbers,
    largest_first,
    taken_as_given,
)
from tendon_cli.answers.decision import decision_record
from tendon_cli.answers.help import Help, what_would_help
from tendon_cli.answers.limit_curves import curves_of
from tendon_cli.answers.needed_parts import parts_record
from tendon_cli.answers.notes import (
    PROOF_METHOD,
    note_on_motion,
    note_without_fresh_sample,
    scope_words,
)
from tendon_cli.answers.question_facts import (
    condition_values,
    goal_record,
    notes_of,
    question_record,
    value_at,
    with_named_rows,
)
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.setup import drift_record, setting_record
from tendon_cli.answers.tables import VERIFIED, as_records, choice_columns, choice_rows
from tendon_cli.answers.verified_record import fresh_record, verified_record
from tendon_cli.engine.cutoff_check import check_of_designs
from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.engine.task import Note
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.window import Ends
from tendon_cli.proof.certify import Certificate, Report, certify
from tendon_cli.space.axis import PRETENSION
from tendon_cli.space.space import Space
from tendon_cli.studies.answer_draws import numbers_of_paper
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.windows import candidates
from tendon_cli.windows.candidates import LimitPair
from tendon_cli.windows.coverage import normalise, serves
from tendon_cli.windows.question import (
    Question,
    affords_motion,
    is_sought,
    of_second_sample,
    rows_to_prove,
    select_numbers,
    with_enough,
)
from tendon_cli.windows.solutions import Solutions, solve, solve_windows
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.study_arm import as_read
from tendon_cli.windows.verification import Verified, Verifier

_MOST_LISTED = 100
"""Most pretensions of a list that are judged one by one."""
Certificates = dict[int, Certificate]
"""Certificates by the rows of their choices, in the order of the proofs."""


@dataclass(eq=False)
class NamedChoices:
    """Choices that an answer names, with their windows proved."""

    question: Question
    best: dict[str, Solutions] = field(default_factory=dict)
    """Best choice by each goal's column; the best compromise of a front under an empty name."""
    front: Solutions | None = None
    """Choices that no other beats, in the order of the first goal; None without several goals."""
    given_up: float | None = None
    """Largest share of the span of any goal on the front that the best compromise gives up."""
    verified: dict[int, Verified] = field(default_factory=dict)
    """Judgements of a fresh sample by the rows of the choices."""

    @classmethod
    def of(cls, question: Question, choices: Solutions) -> NamedChoices:
        """Return the best of some choices of a question."""
        named = cls(question)
        feasible = choices.select(choices.feasible)
        if not len(feasible):
            return named
        if len(question.goals) > 1:
            named.front = candidates.front_of(question, feasible)
            named.best[""] = candidates.compromise(question, named.front)
            lost = candidates.losses(named.front.scores(question.goals))
            named.given_up = float(lost.max(axis=1).min())
            return named
        for name, order in candidates.orders_of(question).items():
            named.best[name] = feasible.select([order.best(feasible)])
        return named

    def certify(self, solver: Solver, certificates: Certificates, report: Report) -> None:
        """Prove the windows of all choices, beginning with the one that is named first."""
        for column, choice in self.best.items():
            self.best[column] = certify_all(solver, choice, certificates, report)
        if self.front is not None:
            self.front = certify_all(solver, self.front, certificates, report)

    def verify(self, verifier: Verifier | None, proved: Solutions | None) -> None:
        """Have a fresh sample judge all choices that the answer names.

        Args:
            verifier: Judge; None without a fresh sample.
            proved: Choices that the study names to be proved.
        """
        choices = [choice for choice in (*self.best.values(), self.front, proved) if choice]
        if verifier is None or not choices:
            return
        named = Solutions.concatenate(choices)
        _, first = np.unique(named.row, return_index=True)
        for place in first:
            choice = named.select([place])
            judged = verifier.judge(choice)
            if judged is not None:
                self.verified[choice.row.item()] = judged

    @property
    def rows_on_front(self) -> Rows:
        """Rows of the choices that no other beats; none if the study leaves its goals open."""
        if self.front is not None:
            return self.front.row
        if len(self.question.goals) == 1 and self.best:
            return next(iter(self.best.values())).row
        return np.empty(0, dtype=np.int64)

    def records(self, choices: Solutions) -> list[ChoiceRecord]:
        """Return choices as rows of the table for JSON, with their rows and what binds them."""
        on_front = np.isin(choices.row, self.rows_on_front)
        rows = choice_rows(self.question, choices) | {"on_front": on_front}
        columns = choice_columns(self.question)
        records = as_records(tuple(one for one in columns if one.name not in VERIFIED), rows)
        return [
            self._record(number, record)
            for number, record in zip(choices.row.tolist(), records, strict=True)
        ]

    def _record(self, number: int, row: dict[str, Any]) -> ChoiceRecord:
        """Return a choice from its row of the table, with the conditions that bind it."""
        under: dict[str, Any] = {}
        for end in ("from", "to"):
            binds = row[f"{end}_by"] is not None
            condition = row[f"{end}_condition"]
            under[f"{end}_under"] = condition_values(self.question, condition) if binds else {}
        judged = self.verified.get(number)
        if judged is not None:
            row["feasible"] = row["feasible"] and judged.is_enough(self.question.serve)
        names = {field.name for field in fields(ChoiceRecord)}
        return ChoiceRecord(
            choice=number,
            served_verified=None if judged is None else verified_record(judged),
            columns={name: value for name, value in row.items() if name not in names},
            **{name: value for name, value in row.items() if name in names},
            **under,
        )


def certify_all(
    solver: Solver, choices: Solutions, certificates: Certificates, report: Report
) -> Solutions:
    """Return choices with their windows proved, or tightened.

    Args:
        solver: Solver of the question.
        choices: The choices.
        certificates: Certificates so far, to which those of the other choices are added.
        report: Called as each proof goes on.
    """
    proved = []
    for place in range(len(choices)):
        choice = choices.select([place])
        row = choice.row.item()
        if row not in certificates:
            certificates[row] = _certificate(solver, choice, report)
        proved.append(certificates[row].solution)
    return Solutions.concatenate(proved)


def _certificate(solver: Solver, choice: Solutions, report: Report) -> Certificate:
    """Return the proof of one choice's window under the question's own sample.

    A choice that a second sample has set keeps its window and its setting.
    """
    question = solver.question
    if not question.sample.sets_by_sample:
        return certify(solver, choice, report)
    of_sample = solver.for_question(with_enough(question, question.serve))
    solved, _ = solve_windows(of_sample, choice.points)
    proof = certify(of_sample, solved, report)
    status = proof.solution.between_samples
    return replace(proof, solution=replace(choice, between_samples=status))


@dataclass(frozen=True, eq=False)
class Made:
    """The record of an answer, and the choice that its part on persons or draws is about."""

    record: AnswerResults
    chosen: Solutions
    """Choice that is named first, or else the one that serves most."""
    row: ChoiceRecord
    """Its row in the table."""
    judged: Verified | None
    """Judgement of a fresh sample on it; None without one."""


def make_record(solver: Solver, notes: Sequence[Note], report: Report) -> Made:
    """Make the record of an answer.

    Choices that may matter are solved again, since the notes have only their rows. A choice that
    seems to have a window may lose it by the proof: then the best are chosen again without it.

    Args:
        solver: Solver of the question.
        notes: Notes of all parts.
        report: Called as each proof goes on.

    Returns:
        The record, and the choice that is named first, or else the one that serves most.
    """
    question = solver.question
    to_prove = rows_to_prove(question)
    relevant_rows = [row for note in notes for row in note["rows"]]
    rows = np.unique([*relevant_rows, *to_prove.tolist()])
    with_motion = replace(solver, with_motion=affords_motion(question, len(rows)))
    solver = replace(solver, with_motion=False)
    of_own_sample = solve(with_motion, question.points(rows))
    before_proofs = _set_by_second_sample(with_motion, of_own_sample, to_prove)
    conflicts = Counter[LimitPair]()
    for note in notes:
        conflicts.update({tuple(names): count for names, count in note["conflicts"]})
    relevant, named, certificates, proved = _with_proofs(
        with_motion, before_proofs, to_prove, report
    )
    is_set = np.isin(of_own_sample.row, relevant.row)
    lost = int(of_own_sample.feasible[is_set].sum()) - int(relevant.feasible.sum())
    verifier = Verifier.of(solver)
    named.verify(verifier, proved)
    chosen = next(iter(named.best.values()), None)
    named_first = chosen
    if named_first is None:
        named_first = candidates.nearest(named.question, relevant)
    judged = named.verified.get(named_first.row.item())
    if judged is None and verifier is not None:
        judged = verifier.judge(named_first)
    help_ = Help()
    between = None
    window_for_all = None
    parts = None
    setting = None
    drift = None
    slopes: list[SensitivityRecord] = []
    decided = None
    if chosen is None:
        binding = {limit for pair in conflicts for limit in pair}
        help_ = what_would_help(solver, named_first, binding, verifier)
    else:
        of_chosen = next(iter(certificates.values()))
        between = _between_samples(solver, chosen, of_chosen, certificates)
        window_for_all = _window_for_all(question, of_chosen.ends)
        setting = setting_record(question, chosen, named.verified.get(chosen.row.item()))
        drift = drift_record(question, chosen)
        slopes = sensitivities(*_nominal(solver, chosen))
        decided = decision_record(named.question, notes, before_proofs, chosen, setting.accuracy)
        parts = parts_record(solver, chosen, of_chosen.ends)
    best = {column: named.records(choice)[0] for column, choice in named.best.items()}
    record = AnswerResults(
        question=question_record(question),
        choices=sum(note["choices"] for note in notes),
        conditions=len(question.conditions),
        feasible=sum(note["feasible"] for note in notes) - lost,
        trade_offs=[*_trade_offs(named, relevant, certificates)],
        serve=question.serve,
        verified_by=None if verifier is None else fresh_record(verifier.sample),
        goals=[goal_record(goal) for goal in question.goals],
        best=next(iter(best.values()), None),
        best_by={column: row for column, row in best.items() if column and not question.goals},
        decided=decided,
        given_up=named.given_up,
        window_for_all=window_for_all,
        front=[] if named.front is None else named.records(named.front),
        setting=setting,
        drift=drift,
        parts_needed=parts,
        sensitivities=slopes,
        assumed=_assumed(solver, named_first, relevant, verifier, judged, slopes),
        listed=_listed(solver, named_first, judged),
        of_paper=numbers_of_paper(question.stated or question.study),
        checks=_checks(solver, named_first),
        between_samples=between,
        proved=[] if proved is None else named.records(proved),
        conflicts=[*_conflicts(solver, named, of_own_sample, conflicts)],
        fixes=[*help_.fixes],
        would_take=[*help_.relaxations],
        notes=[*_notes(question, verifier), *help_.notes],
        population=None,
    )
    row_of_first = named.records(named_first)[0]
    record.question = with_named_rows(record.question, (record, row_of_first))
    return Made(record, named_first, row_of_first, judged)


def _set_by_second_sample(solver: Solver, choices: Solutions, to_prove: Rows) -> Solutions:
    """Return the best choices as a second and larger sample sets them, if the question has one.

    Args:
        solver: Solver of the question.
        choices: Choices that may matter in some part of the work.
        to_prove: Rows that the study asks to be proved.
    """
    second = Verifier.of(solver, second=True) if solver.question.sample.sets_by_sample else None
    if second is None:
        return choices
    asked_for = np.flatnonzero(np.isin(choices.row, to_prove))
    best = np.union1d(candidates.relevant(choices, solver.question), asked_for)
    return second.set_choices(choices.select(best))


class WithProofs(NamedTuple):
    """Choices after the proofs of those that the answer names."""

    relevant: Solutions
    """Choices that may matter; those that lost their window by a proof have none."""
    named: NamedChoices
    certificates: Certificates
    proved: Solutions | None
    """Choices that the study asked to be proved; None if it asked for none."""


def _with_proofs(solver: Solver, relevant: Solutions, to_prove: Rows, report: Report) -> WithProofs:
    """Prove the choices that an answer names, until none of them loses its window.

    Args:
        solver: Solver of the question.
        relevant: Choices that may matter.
        to_prove: Rows that the study asks to be proved.
        report: Called as each proof goes on.
    """
    while True:
        named = NamedChoices.of(of_second_sample(solver.question), relevant)
        certificates: Certificates = {}
        named.certify(solver, certificates, report)
        proved = None
        if len(to_prove):
            asked_for = relevant.select(np.isin(relevant.row, to_prove))
            proved = certify_all(solver, asked_for, certificates, report)
        lost = _lost_windows(relevant, certificates)
        if not lost:
            return WithProofs(relevant, named, certificates, proved)
        is_unchanged = ~np.isin(relevant.row, [choice.row.item() for choice in lost])
        relevant = Solutions.concatenate([relevant.select(is_unchanged), *lost])


def _lost_windows(relevant: Solutions, certificates: Certificates) -> list[Solutions]:
    """Return proved choices that have no window, although they seemed to have one before."""
    seemed_feasible = relevant.row[relevant.feasible]
    choices = [certificate.solution for certificate in certificates.values()]
    return [
        choice
        for choice in choices
        if not choice.feasible.item() and choice.row.item() in seemed_feasible
    ]


def _trade_offs(
    named: NamedChoices, choices: Solutions, certificates: Certificates
) -> Iterator[TradeOffRecord]:
    """Yield the best choice with each value of each limit on which the choices differ.

    Args:
        named: Choices that the answer names.
        choices: Relevant choices.
        certificates: Certificates of the choices whose windows were proved.
    """
    question = named.question
    feasible = choices.select(choices.feasible)
    axes = {axis.key: axis for axis in question.choices.axes}
    for key, of_values in candidates.by_limits(question, feasible).items():
        best: list[ChoiceRecord | None] = []
        for rows in of_values:
            record = None
            if len(rows):
                first = candidates.named_first(question, feasible.select(rows))
                certificate = certificates.get(first.row.item())
                proved = first if certificate is None else certificate.solution
                (record,) = named.records(proved)
            best.append(record)
        values = [value_at(axes[key], place) for place in range(len(axes[key]))]
        yield TradeOffRecord(key=key, column=axes[key].column, values=values, best=best)


def _between_samples(
    solver: Solver, chosen: Solutions, of_chosen: Certificate, certificates: Certificates
) -> BetweenSamples:
    """Return the record of all proofs, with the scope and curves of the choice named first."""
    scope = of_chosen.scope
    of_each = [
        ChoiceCertificate(
            status=certificate.status,
            cells=certificate.cells,
            margin=certificate.margin,
            estimate=certificate.estimate,
            choice=row,
        )
        for row, certificate in certificates.items()
    ]
    return BetweenSamples(
        status=of_chosen.status,
        cells=of_chosen.cells,
        margin=of_chosen.margin,
        estimate=of_chosen.estimate,
        choices=of_each,
        method=PROOF_METHOD,
        scope=scope_words(scope.angles, scope.ranges, _times(solver.question)),
        curves=curves_of(solver, chosen, of_chosen.ends),
    )


def _times(question: Question) -> tuple[float, float] | None:
    """Return the first and the last time that count in a motion in time, s; None without one."""
    trajectory = question.study.trajectory
    if trajectory is None:
        return None
    counted = trajectory.time[trajectory.counted]
    return float(counted[0]), float(counted[-1])


def _checks(solver: Solver, choice: Solutions) -> ChecksRecord | None:
    """Return the checks of a choice at its pretension, None without a trajectory.

    A choice without a window is checked at the pretension that it asks for, or else at the study's.
    """
    stated = solver.question.study.numbers[PRETENSION].array[:1]
    known = (choice.pretension, choice.pretension_from, stated)
    pretension = next(values for values in known if np.isfinite(values).all())
    at_pretension = choice.points.at_pretension(pretension)
    designs = (design for _, _, design in solver.portions(at_pretension))
    check = check_of_designs(solver.question.study, designs)
    return None if check is None else ChecksRecord(cutoff=check)


def _nominal(solver: Solver, choice: Solutions) -> tuple[Solver, Solutions]:
    """Return the solver of the suit without deviations where these are drawn, and its solution."""
    question = solver.question
    if not question.study.usual:
        return solver, choice
    others = tuple(axis for axis in question.conditions.axes if axis.role != "draw")
    sample = replace(question.sample, enough=1.0, sets_by_sample=False)
    exact = replace(question, conditions=Space(others), serve=1.0, sample=sample)
    of_suit = solver.for_question(exact)
    return of_suit, solve(of_suit, choice.points)


def _listed(solver: Solver, choice: Solutions, judged: Verified | None) -> list[ListedRecord]:
    """Return the pretensions that a study lists, judged with one choice.

    A fresh sample judges, or without one the conditions.
    """
    question = solver.question
    stated = question.study.numbers[PRETENSION]
    if not stated.is_axis or len(stated) > _MOST_LISTED:
        return []
    low, high = judged.windows if judged is not None else _windows_of(solver, choice)
    weights = np.ones(len(low)) if judged is None else judged.sample.weighting
    repeated = choice.points.select(np.zeros(len(stated), dtype=np.int64))
    readings = as_read(question, repeated, stated.array)
    records = []
    for pretension, reading in zip(stated.array.tolist(), readings.tolist(), strict=True):
        share = float(normalise(weights) @ serves(low, high, reading))
        records.append(ListedRecord(pretension=pretension, reading=reading, served=min(share, 1.0)))
    return records


def _windows_of(solver: Solver, choice: Solutions) -> tuple[Array, Array]:
    """Return the ends of the windows of one choice under each group, (groups,) each, N."""
    ends = solver.ends(choice.points)
    low, high = solver.question.groups.windows(ends.low, ends.high)
    return low[0], high[0]


def _assumed(
    solver: Solver,
    choice: Solutions,
    others: Solutions,
    verifier: Verifier | None,
    judged: Verified | None,
    slopes: list[SensitivityRecord],
) -> list[AssumedRecord]:
    """Return what an answer assumes, what moves the window most first.

    Args:
        solver: Solver of the question.
        choice: The choice that is named first.
        others: All choices that may be named.
        verifier: Judge; None without a fresh sample.
        judged: Its judgement of the choice.
        slopes: Derivatives of the ends of the window.
    """
    question = solver.question
    if verifier is not None and judged is not None:
        numbers = verifier.sample.axis.numbers
        assumed = drawn_deviations(question, choice, numbers, *judged.windows)
    elif question.study.usual:
        numbers = select_numbers(question.condition_numbers, question.groups.first_conditions)
        assumed = drawn_deviations(question, choice, numbers, *_windows_of(solver, choice))
    else:
        return largest_first(exact_numbers(question, slopes))
    if question.study.usual and not is_sought(question):
        assumed += taken_as_given(solver, choice, others)
    return largest_first(assumed)


# --- The record -----------------------------------------------------------------------------------


def _window_for_all(question: Question, ends: Ends) -> list[float | None] | None:
    """Return the window that serves all, N; None if there is none, or if all must be served."""
    if question.serve >= 1.0:
        return None
    low = float(ends.low.max())
    high = float(ends.high.min())
    if not low <= high:
        return None
    return [low, finite_or_none(high)]


def _notes(question: Question, verifier: Verifier | None) -> Iterator[str]:
    """Yield the notes of a question, and on worst values or a fresh sample that it lacks."""
    yield from notes_of(question)
    if verifier is None and question.conditions.groups is not None:
        is_wanted = question.study.design.verify > 0
        yield note_without_fresh_sample(question.groups.noun, is_wanted=is_wanted)
    choices = len(question.choices)
    if columns_of_motion(question.study) and not affords_motion(question, choices):
        yield note_on_motion(choices)


def _conflicts(
    solver: Solver, named: NamedChoices, relevant: Solutions, conflicts: Counter[LimitPair]
) -> Iterator[ConflictRecord]:
    """Yield the limits that leave choices without a window, the most frequent conflict first.

    `gap` is the distance between the pretensions asked for, N, in the choice that is nearest to a
    window; null if there is no such distance.
    """
    rows_of_pairs = candidates.conflicts_of(relevant)
    for pair, count in sorted(conflicts.items(), key=lambda of_pair: (-of_pair[1], of_pair[0])):
        closest = candidates.nearest(named.question, relevant.select(rows_of_pairs[pair]))
        gap = float(closest.pretension_from[0]) - float(closest.pretension_to[0])
        yield ConflictRecord(
            limits=list(pair),
            choices=count,
            gap=finite_or_none(gap),
            nearest=named.records(closest)[0],
            fails=_failing_conditions(solver, closest),
        )


def _failing_conditions(solver: Solver, choice: Solutions) -> list[Values]:
    """Return the conditions that a choice does not keep; none if persons or draws are counted."""
    question = solver.question
    if question.conditions.groups is not None:
        return []
    ends = solver.ends(choice.points)
    is_kept = serves(ends.low, ends.high, choice.pretension[:, np.newaxis])[0]
    return [condition_values(question, row) for row in np.flatnonzero(~is_kept).tolist()]


def named_rows(record: AnswerResults) -> list[ChoiceRecord]:
    """Return the choices that a record names, in the order of their rows in the table."""
    rows = [*record.proved]
    if record.best:
        rows.append(record.best)
    rows += [*record.best_by.values(), *record.front]
    named = {row.choice: row for row in rows}
    return [named[choice] for choice in sorted(named)]
