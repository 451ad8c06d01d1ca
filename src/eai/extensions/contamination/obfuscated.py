"""Obfuscated benchmarks, in which predicates, operators and categories have swapped names.

A planner needs the rules of actions, not their names. An obfuscated benchmark permutes the names of
predicates, operators and categories of objects, in the same way in all tasks. Only names with equal use, such
as names of operators with two objects, are exchanged. World, tasks and verdicts stay unchanged. Unlike plain
prompts, its prompts define each word and state the exact rules. `open_with_rules` opens a benchmark for
comparison: its prompts state the exact rules with the true names.
"""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import eai.logic.formula as f
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.notation.subgoals import SubgoalNotation, WrittenSubgoals
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.names import OBFUSCATED, WITH_RULES
from eai.benchmarks.registry import find_benchmark
from eai.tasks.english import PLAIN_ENGLISH, EnglishWords, make_predicate_sentences
from eai.tasks.lexicon import FormulaNameLexicon
from eai.tasks.operator_task import TransitionTask
from eai.tasks.prompts.short import RULES
from eai.tasks.rules import DomainRulesInPrompts, explain_rule_notation
from eai.tasks.source import USUAL_SOURCE, TaskSet
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording, is_unchanging_object_property
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.effect import When
from eai.world.operator import Operator, affordance
from eai.world.state import Fact, Scene
from eai.world.vocabulary import make_parameter_names

_TOKEN = re.compile(r"[A-Za-z_][\w-]*(?:\.\w+)*")
_NUMBERED = re.compile(r"(.+?)([._]\d+)")
_FORMAT_WORDS = frozenset(
    (
        *("action", "object", "output", "not", "and", "or", "then", "until", "implies", "next", "eventually"),
        *("always", "true", "false", "forall", "exists", "forn", "forpairs", "fornpairs", "x", "y", "z"),
        *("requires", "needed", "only", "if", "becomes", "for", "each", "with", "the", "first", "means"),
        *("is_a", "changes", "nothing"),
    )
)
"""Words of prompts and answer formats that an obfuscated benchmark does not replace by new names."""

UNCHANGING = "Facts that no action changes:"
"""Heading of a list of facts in obfuscated prompts. Plain prompts state these facts in sentences instead."""


def _make_word_cipher(benchmark: Benchmark, tasks: Iterable[Task]) -> Mapping[str, str]:
    """Return a mapping from each renamed word of a benchmark to its new name, equal on every machine."""
    wording, arity = benchmark.wording(Ability.ACTION_SEQUENCING), benchmark.domain.vocabulary.find_arity
    used = [(name, ("predicate", arity(name))) for name in (*wording.predicates, *wording.static)]
    used += [(operator.name, ("operator", operator.arity)) for operator in benchmark.domain.operators]
    uses = group_pairs(used)
    alike: list[tuple[object, tuple[str, ...]]] = [(frozenset(use), (name,)) for name, use in uses.items()]
    for category, stems in _map_categories_to_object_name_stems(tasks).items():
        if not {category, *stems} & uses.keys():
            alike.append(((category in stems, len(stems)), (category, *stems)))
    digest = hashlib.sha256(f"obfuscated {benchmark.domain.name}".encode()).digest()
    rng, words = random.Random(digest), dict[str, str]()  # noqa: S311 - names, not secrets
    for group in group_pairs(alike).values():
        changing = [names for names in group if _FORMAT_WORDS.isdisjoint(names)]
        start = rng.sample(changing, len(changing))
        # Each name is replaced by the next name, so every name changes, except a name without others.
        for old, new in zip(start, (*start[1:], *start[:1]), strict=True):
            words |= dict(zip(old, new, strict=True))
    return words


def _replace_words(words: Mapping[str, str], text: str) -> str:
    """Replace words in a text. Names of objects keep their numbers: ``cup_2`` becomes ``NAME_2``."""
    return _TOKEN.sub(lambda token: _replace_token(token[0], words), text)


def _restore_words(words: Mapping[str, str], text: str) -> str:
    """Replace new names in an answer by the old names. Answers may write names with other capitals."""
    other_capitals = {
        change(new): change(old)
        for change in (str.capitalize, str.upper, str.lower)
        for old, new in words.items()
        if change(new) not in _FORMAT_WORDS
    }
    return _replace_words({**other_capitals, **{new: old for old, new in words.items()}}, text)


def _replace_token(token: str, words: Mapping[str, str]) -> str:
    if token in words:
        return words[token]
    numbered = _NUMBERED.fullmatch(token)
    return token if numbered is None else words.get(numbered[1], numbered[1]) + numbered[2]


def _map_categories_to_object_name_stems(tasks: Iterable[Task]) -> Mapping[str, tuple[str, ...]]:
    """Return a mapping from each category, except agents, to its objects' names without numbers."""
    stems_of: dict[str, dict[str, None]] = {}
    owner: dict[str, str] = {}
    agents = set()
    for task in tasks:
        for index, thing in enumerate(task.scene.objects):
            numbered = _NUMBERED.fullmatch(thing.name)
            stem = thing.name if numbered is None else numbered[1]
            if owner.setdefault(stem, thing.category) == thing.category:
                stems_of.setdefault(thing.category, {})[stem] = None
            for kind in task.scene.vocabulary.list_kind_with_ancestors(thing.category)[1:]:
                stems_of.setdefault(kind, {})
            if index == task.scene.agent:
                agents.add(thing.category)
    return {category: tuple(sorted(stems)) for category, stems in stems_of.items() if category not in agents}


@dataclass(frozen=True)
class _ObfuscatedWording(PromptAndAnswerWording):
    """A wording of prompts with swapped names, which states every requirement and effect of the actions.

    Attributes:
        words: the new name of each renamed word.
        english: the English sentence for each predicate.
    """

    words: Mapping[str, str] = field(default_factory=dict)
    english: EnglishWords = PLAIN_ENGLISH

    @cached_property
    def _domain_rules_showing_hidden_predicates(self) -> DomainRulesInPrompts:
        """The requirements and effects of all actions in formal notation, without English explanations.

        They include the predicates that the prompts of the original benchmark do not show.
        """
        vocabulary = self.domain.vocabulary
        predicates = vocabulary.predicates
        shown = [
            predicate if is_unchanging_object_property(predicate) else replace(predicate, visible=True)
            for predicate in predicates
        ]
        operators = tuple(map(_convert_alternatives_to_conditional_effects, self.domain.operators))
        told = replace(
            self.domain, vocabulary=replace(vocabulary, predicates=tuple(shown)), operators=operators
        )
        return DomainRulesInPrompts(told)

    @cached_property
    def _predicates_used_in_domain_rules(self) -> frozenset[str]:
        return self._domain_rules_showing_hidden_predicates.find_used_predicates(
            self._domain_rules_showing_hidden_predicates.operator_names
        )

    def describe_vocabulary(self) -> str:
        names = (*self.predicates, *self.static)
        lines = _replace_words(self.words, super().describe_vocabulary()).splitlines()
        return "\n".join(
            f"{line}: {self._explain_predicate(name)}" for line, name in zip(lines, names, strict=True)
        )

    def _explain_predicate(self, predicate: str) -> str:
        arity = self._find_predicate_arity(predicate)
        return make_predicate_sentences(predicate, arity, self.english)[0].format(
            **{x: x for x in make_parameter_names(arity)}
        )

    def describe_operators(self) -> str:
        definitions = [
            _replace_words(self.words, definition)
            for definition in self._domain_rules_showing_hidden_predicates.write_predicate_definitions()
        ]
        rules = "\n".join(
            [
                *map(self.describe_operator, self._domain_rules_showing_hidden_predicates.operators),
                *definitions,
            ]
        )
        return f"{explain_rule_notation(rules)}\n{rules}"

    def write_operators_heading(self, phrase_for_one_action: str) -> str:
        return f"what {phrase_for_one_action} requires and changes"

    def describe_operator(self, operator: Operator) -> str:
        return _replace_words(
            self.words, self._domain_rules_showing_hidden_predicates.write_operator_rule(operator) or ""
        )

    def describe_object(self, task: Task, index: int) -> str:
        properties = [
            p for p in self.domain.vocabulary.predicates if is_unchanging_object_property(p) and not p.visible
        ]
        hidden = [p.name for p in properties if p.name in self._predicates_used_in_domain_rules]
        having = [_replace_words(self.words, name) for name in hidden if task.initial.has(name, index)]
        head, _, known = _replace_words(self.words, super().describe_object(task, index)).rpartition(": ")
        return f"{head}: {', '.join([*(known.split(', ') if known != '-' else ()), *having]) or '-'}"

    def write_static_facts_used_by_rules(self, task: Task) -> str:
        """Return the facts that no action changes and that the rules of actions use.

        The facts stand one a line below the heading `UNCHANGING`. Prompts of the original benchmark state
        them as English sentences instead.
        """
        named = self._predicates_used_in_domain_rules.intersection(self.unchanging)
        properties = {p.name for p in self.domain.vocabulary.predicates if is_unchanging_object_property(p)}
        listed, lines = {*self.list_prompt_objects(task)}, [UNCHANGING]
        for predicate, arguments in task.initial.facts():
            if predicate in named and not (predicate in properties and arguments[0] in listed):
                lines.append(_replace_words(self.words, self.write_fact(task, Fact(predicate, arguments))))
        return "\n".join(lines) if lines[1:] else ""

    def describe_initial_state(self, task: Task) -> str:
        return _replace_words(self.words, super().describe_initial_state(task))

    def describe_goals(self, task: Task) -> str:
        return _replace_words(self.words, super().describe_goals(task))


def _convert_alternatives_to_conditional_effects(operator: Operator) -> Operator:
    """Return an equivalent operator whose alternatives are replaced by conditional effects.

    An alternative is another way to act. It is attempted if its condition holds. The operator's description
    is dropped, because the prompts state formal rules only.
    """
    tried = [f.And(attempt.conditions) for attempt in operator.alternatives]
    effects = [
        When(need, attempt.effects) for need, attempt in zip(tried, operator.alternatives, strict=True)
    ]
    none = f.Not(f.Or(tuple([attempt.condition for attempt in operator.alternatives])))
    checks_of_tries = (
        [affordance(f.Or((*tried, none)), "none of several things can be done")] if tried else []
    )
    return replace(
        operator,
        description="",
        alternatives=(),
        checks=(*operator.checks, *checks_of_tries),
        effects=(*effects, *operator.effects),
    )


class _PlanNotationWithSwappedNames(PlanNotation):
    """Reads and writes plans in which predicates, operators and categories have swapped names."""

    def __init__(self, plain: PlanNotation, words: Mapping[str, str]) -> None:
        self._plain, self._words = plain, words

    def replace_domain_names_by_answer_words(self, text: str) -> str:
        return _replace_words(self._words, text)

    def replace_answer_words_by_domain_names(self, text: str) -> str:
        return _restore_words(self._words, text)

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        return replace(self._plain.read(self.replace_answer_words_by_domain_names(text), actions), spans=())

    def to_operator_name(self, word: str) -> str:
        return self._plain.to_operator_name(word)

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        return self._plain.make_object_lookup(task)

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        return tuple(map(self.replace_domain_names_by_answer_words, self._plain.write(plan, scene)))

    def join(self, answer_parts: Iterable[str]) -> str:
        return self._plain.join(answer_parts)


class _SubgoalNotationWithSwappedNames(SubgoalNotation):
    """Reads and writes subgoals in which predicates, operators and categories have swapped names."""

    def __init__(self, plain: SubgoalNotation, words: Mapping[str, str]) -> None:
        super().__init__(plain.domain)
        self._plain, self._words = plain, words

    def get_domain_for_executing_subgoals(self) -> Domain:
        return self._plain.get_domain_for_executing_subgoals()

    def make_lexicon_of_names_in_subgoals(self, scene: Scene) -> FormulaNameLexicon:
        return self._plain.make_lexicon_of_names_in_subgoals(scene)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        return replace(self._plain.read(_restore_words(self._words, text)), spans=())

    def write(self, task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
        return tuple([_replace_words(self._words, part) for part in self._plain.write(task, plan)])

    def join(self, answer_parts: Iterable[str]) -> str:
        return self._plain.join(answer_parts)


def open_obfuscated(benchmark_name: str) -> Benchmark:
    """Open a benchmark with swapped names. Its tasks ask only for plans and subgoals."""
    benchmark = find_benchmark(benchmark_name)
    public = benchmark.data.open_public or benchmark.open_tasks
    return _make_benchmark_with_rules_in_prompts(
        benchmark, _make_word_cipher(benchmark, public(USUAL_SOURCE).values()), OBFUSCATED
    )


def open_with_rules(benchmark_name: str) -> Benchmark:
    """Open a benchmark with its true names, and with prompts that list all rules of actions.

    Obfuscated prompts list these rules too, so comparisons show the effect of the names alone.
    """
    return _make_benchmark_with_rules_in_prompts(find_benchmark(benchmark_name), {}, WITH_RULES)


def _make_benchmark_with_rules_in_prompts(
    benchmark: Benchmark, word_cipher: Mapping[str, str], suffix: str
) -> Benchmark:
    def make_wording_with_stated_rules(ability: Ability) -> PromptAndAnswerWording:
        plain = benchmark.wording(ability)
        twin = _ObfuscatedWording(
            plain.domain,
            plain.predicates,
            plain.answer_names,
            plain.object_name,
            static=plain.static,
            hands=plain.hands,
            unchanging=plain.unchanging,
            surroundings=plain.surroundings,
            words=word_cipher,
            english=benchmark.notation.english,
        )
        if plain.conventions is None:
            return twin
        return replace(twin, conventions=twin.write_static_facts_used_by_rules)

    asks_subgoals = benchmark.data.asks.get(Ability.SUBGOAL_DECOMPOSITION)

    no_operators = TaskSet((), dict[str, TransitionTask]().__getitem__, "")

    def encipher_capitalised_words(text: str) -> str:
        return _TOKEN.sub(lambda t: _replace_token(t[0], word_cipher) if t[0].isupper() else t[0], text)

    return replace(
        benchmark,
        name=f"{benchmark.name}{suffix}",
        notation=replace(
            benchmark.notation,
            plans=_PlanNotationWithSwappedNames(benchmark.notation.plans, word_cipher),
            subgoals=_SubgoalNotationWithSwappedNames(benchmark.subgoal_notation(), word_cipher),
            formats={
                ability: encipher_capitalised_words(text)
                for ability, text in benchmark.notation.formats.items()
            },
            short_texts={
                name: encipher_capitalised_words(text)
                for name, text in benchmark.notation.short_texts.items()
                if name != RULES
            },
            wordings=make_wording_with_stated_rules,
        ),
        data=replace(
            benchmark.data,
            title=f"{benchmark.title}, {suffix[1:]}",
            prompts=None,
            own_tasks={Ability.TRANSITION_MODELING: lambda source: no_operators},
            asks={
                Ability.GOAL_INTERPRETATION: lambda task: False,
                # prompts of ambiguous tasks give goals only as an instruction, whose words are not obfuscated
                Ability.ACTION_SEQUENCING: lambda task: task.has_goals_in_prompts,
                Ability.SUBGOAL_DECOMPOSITION: lambda task: (
                    task.has_goals_in_prompts and (asks_subgoals is None or asks_subgoals(task))
                ),
            },
        ),
        reference="",
    )
