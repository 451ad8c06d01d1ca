"""Goal interpretation in BEHAVIOR: from an answer's text to counts.

A goal can be met in several ways, its ground options; the option that the answer meets best is what the
answer is compared with. Protocol `strict` mends these defects of eai-eval 1.0.5 (``evaluate_results.py``):

- A condition that stands in two goals counts twice there, and so does a wrong one that is said twice.
- ``nextto`` has a direction there.
- Of several options that meet equally many conditions, the first counts there, here the shortest.
- A wrong condition whose predicate does not exist is neither a state nor a relation there; here its length
  decides.
- JSON is found in prose, behind reasoning and in any code fence, and no answer aborts a run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import partial

from eai.abilities.explanation import Explanation, GoalReport, repairs_told
from eai.abilities.goal_interpretation import behavior_answer
from eai.abilities.goal_interpretation.behavior_conditions import Seen, Unreadable, Value, Written, see
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task import GoalKind
from eai.abilities.verdict import Confusion, ErrorReport, Json, Verdict
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.reference import behavior_goals as behavior_reference
from eai.world.fault import FaultKind

Option = tuple[Value, ...]


class GoalInterpretation(Scorer):
    """The scorer of one task under one protocol.

    A verdict's counts are those of state goals, relation goals and ``all``. Its details say how many
    conditions the answer has (``predicted``), how many of them have not one or two objects (``ill_formed``),
    name the objects that do not exist (``hallucinated``) and the predicates (``unknown_predicates``), and
    tell whether the reference would abort its run (``aborts``).
    """

    def __init__(self, task: BehaviorTask, protocol: Protocol) -> None:
        self.task = task
        self.protocol = protocol
        self._strict = protocol is Protocol.STRICT
        self._goals: tuple[tuple[Option, ...], ...] = tuple(
            tuple(map(_canonical, options)) if self._strict else options
            for options in task.interpretation_goals
        )
        self._objects = frozenset(thing.instance for thing in task.record.objects)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and which goals of the task it has, and what else it says."""
        written = self.read(text)
        if isinstance(written, Unreadable):
            return Assessment(self._unread(written), partial(Explanation, (f"parsing: {written.reason}",)))
        verdict = Verdict(
            counts=self._counts(written.conditions),
            repairs=written.repairs,
            details={**self._details(written.conditions), "aborts": False},
        )
        return Assessment(verdict, partial(self._explain, written))

    def _unread(self, written: Unreadable) -> Verdict:
        return Verdict(
            error=ErrorReport(FaultKind.PARSING, None, written.reason),
            counts=self._counts(()),
            details={**self._details(()), "aborts": written.aborts},
        )

    def _explain(self, written: Written) -> Explanation:
        predicted = frozenset(written.conditions)
        chosen = [self._best(options, predicted) for options in self._goals]
        wanted = {condition for option in chosen for condition in option}
        wrong = dict.fromkeys(each for each in written.conditions if each not in wanted)
        return Explanation(
            notes=(
                *repairs_told(written.repairs),
                *(f"wrong: {_text(condition)}" for condition in wrong),
            ),
            goals=tuple(
                GoalReport(
                    "condition",
                    " and ".join(map(_text, option)),
                    all(condition in predicted for condition in option),
                )
                for option in chosen
            ),
        )

    def read(self, text: str) -> Written | Unreadable:
        """The conditions as written, or why there are none."""
        if self.protocol is Protocol.EAI_1_0_5:
            return behavior_reference.read_conditions(text)
        return behavior_answer.read_conditions(text)

    def _counts(self, predicted: Sequence[Value]) -> dict[str, Confusion]:
        said = frozenset(predicted)
        wanted: Sequence[Value] = [c for options in self._goals for c in self._best(options, said)]
        if self._strict:
            wanted = tuple(dict.fromkeys(wanted))
        met = [condition for condition in wanted if condition in said]
        missed = [condition for condition in wanted if condition not in said]
        needed = frozenset(wanted)
        wrong = [condition for condition in predicted if condition not in needed]
        by_kind = {
            kind.value: Confusion(*(self._number(kind, group) for group in (met, wrong, missed)))
            for kind in (GoalKind.STATE, GoalKind.RELATION)
        }
        return {**by_kind, "all": Confusion(len(met), len(wrong), len(missed))}

    def _best(self, options: Sequence[Option], said: Collection[Value]) -> Option:
        """The option that meets most conditions; of several, under `strict`, the shortest, then the first."""

        def rank(option: Option) -> tuple[int, int]:
            met = sum([condition in said for condition in option])
            return met, -len(option) if self._strict else 0

        return max(options, key=rank)

    def _number(self, kind: GoalKind, conditions: Iterable[Value]) -> int:
        return sum(self._kind(see(condition)) is kind for condition in conditions)

    def _kind(self, seen: Seen | None) -> GoalKind | None:
        """State or relation: by the predicate, and under `strict` else by the number of objects."""
        if seen is None or seen.kind is not None or not self._strict or not seen.is_well_formed:
            return None if seen is None else seen.kind
        return GoalKind.STATE if len(seen.arguments) == 1 else GoalKind.RELATION

    def _details(self, conditions: Sequence[Value]) -> dict[str, Json]:
        seen = [see(condition) for condition in conditions]
        understood = [each for each in seen if each is not None]
        unknown = [each for each in understood if each.kind is None]
        strangers = [each for each in understood if any(a not in self._objects for a in each.arguments)]
        return {
            "predicted": len(conditions),
            "ill_formed": sum(each is None or not each.is_well_formed for each in seen),
            "hallucinated": [_first_stranger(each.arguments, self._objects) for each in strangers],
            "unknown_predicates": [str(each.predicate) for each in unknown],
        }


def _canonical(option: Option) -> Option:
    return tuple(dict.fromkeys(map(behavior_answer.canonical, option)))


def _first_stranger(arguments: Iterable[Value], objects: Collection[str]) -> str:
    return next(str(argument) for argument in arguments if argument not in objects)


def _text(condition: Value) -> str:
    match condition:
        case ("not", inner):
            return f"not {_text(inner)}"
        case (predicate, *arguments):
            return f"{predicate}({', '.join(map(str, arguments))})"
        case _:
            return str(condition)
