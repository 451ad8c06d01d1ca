"""A second, naive way to the gold answers: from the text of a prompt and the declaration, on plain sets.

What the prompt says of objects, of what holds, of plans and of choices is all that is known; rules are those
of the declaration. So an answer that comes out also shows that the prompt says what it takes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import product

from eai.extensions.questions.question import Question, QuestionForm, QuestionKind
from eai.logic.formula import Formula
from eai.world.condition import ConditionCompiler
from eai.world.domain import Domain
from eai.world.frame import SlotAllocator
from eai.world.state import Fact, Scene, State, WorldObject
from world.plain_sets import apply, holds

Facts = frozenset[Fact]
Act = tuple[str, tuple[int, ...]]

_OBJECT = re.compile(r"- (\S+) \[(\S+)\](, the agent)?")
_FACT = re.compile(r"([\w-]+)\(((?:[^(){}]|\{[^}]*\})*)\)")
CHOICE = re.compile(r"^([A-D])\. (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class World:
    """The world that a prompt describes, and the declaration."""

    domain: Domain
    scene: Scene
    start: Facts
    told: tuple[str, ...]
    fluents: frozenset[str]

    def possible(self, facts: Facts, act: Act) -> bool:
        return not self.unmet(facts, act)

    def unmet(self, facts: Facts, act: Act) -> list[int]:
        operator = self.domain.find_operator(act[0])
        assert operator is not None
        assert not operator.alternatives
        bound = dict(zip([p.name for p in operator.parameters], act[1], strict=True))
        state = self._state(facts)
        return [
            n for n, check in enumerate(operator.checks, 1) if not holds(state, facts, check.condition, bound)
        ]

    def after(self, facts: Facts, act: Act) -> Facts | None:
        if self.unmet(facts, act):
            return None
        operator = self.domain.find_operator(act[0])
        assert operator is not None
        bound = dict(zip([p.name for p in operator.parameters], act[1], strict=True))
        state, now = self._state(facts), facts
        for effect in operator.effects:
            now = apply(state, facts, now, effect, bound)
        return now

    def _state(self, facts: Facts) -> State:
        return self.scene.state(facts)

    def seen(self, facts: Facts) -> Facts:
        return frozenset(fact for fact in facts if fact.predicate in self.fluents)

    def holds(self, facts: Facts, formula: Formula) -> bool:
        try:
            return holds(self._state(facts), facts, formula, {})
        except TypeError:  # a pairing, which plain sets do not know
            frame = SlotAllocator()
            truth = ConditionCompiler(self.domain.vocabulary, frame).compile_test(formula)
            return truth(self._state(facts), frame.bind_arguments(self.scene, ()))

    def fact(self, text: str) -> Fact:
        ((predicate, names),) = _FACT.findall(text)
        return Fact(predicate, tuple(self.scene.index[n.strip()] for n in names.split(",") if n.strip()))

    def act(self, text: str) -> Act:
        fact = self.fact(text)
        return fact.predicate, fact.arguments

    def said(self, fact: Fact | Act) -> str:
        name, arguments = fact
        return f"{name}({', '.join(self.scene.objects[i].name for i in arguments)})"

    def all_acts(self) -> Iterator[Act]:
        things = range(len(self.scene.objects))
        for name in self.told:
            for arguments in product(things, repeat=self.domain.operator_arities[name]):
                yield name, arguments

    def outcome(self, plan: Iterable[tuple[int, Act]], goals: list[Formula]) -> list[str]:
        facts = self.start
        for number, act in plan:
            unmet = self.unmet(facts, act)
            if unmet:
                return [f"step {number}", f"requirement {unmet[0]}"]
            after = self.after(facts, act)
            assert after is not None
            facts = after
        missed = [f"goal {n}" for n, goal in enumerate(goals, 1) if not self.holds(facts, goal)]
        return missed or ["works"]


def read_world(prompt: str, domain: Domain) -> World:
    """Read the world that a prompt describes."""
    objects, facts, rules = prompt.split("\n\n")[:3]
    found = _OBJECT.findall(objects)
    assert len(found) == len(objects.splitlines()) - 1
    agent = next((i for i, (_, _, marked) in enumerate(found) if marked), None)
    scene = Scene(domain.vocabulary, [WorldObject(name, kind) for name, kind, _ in found], agent)
    start = frozenset(
        Fact(predicate, tuple(scene.index[name] for name in names))
        for line in facts.splitlines()[1:]
        for predicate, arguments in _FACT.findall(line)
        for names in _spread(arguments)
    )
    told = tuple(
        name for name in re.findall(r"^([\w-]+)\(", rules, re.MULTILINE) if name in domain.operator_arities
    )
    fluents = frozenset(p.name for p in domain.vocabulary.predicates if p.visible and not p.static)
    return World(domain, scene, start, told, fluents)


def _spread(arguments: str) -> Iterator[tuple[str, ...]]:
    """Return ``a, {b, c}`` as (a, b) and (a, c)."""
    parts = [part for part in re.findall(r"\{[^}]*\}|[^,{}]+", arguments) if part.strip()]
    options = [part.strip("{}").split(",") if part.startswith("{") else [part] for part in parts]
    return (tuple(name.strip() for name in names) for names in product(*options))


def answer_of(question: Question, domain: Domain, goals: list[Formula]) -> frozenset[str]:
    """Return all right answers to a question; ``goals`` are the goals of its task, as formulas."""
    world = read_world(question.prompt, domain)
    asked = _Asked(question, world, goals)
    right = asked.right()
    if question.form is QuestionForm.OPEN:
        return frozenset(right)
    if question.form is QuestionForm.CHOICE:
        choices = CHOICE.findall(question.prompt)
        assert len(choices) == question.options
        return frozenset(letter for letter, text in choices if asked.is_right(text))
    return frozenset(["yes" if asked.is_right(asked.statement) else "no"])


@dataclass
class _Asked:
    question: Question
    world: World
    goals: list[Formula]
    known: dict[tuple[Facts | None, str | None], tuple[list[Facts], list[int]]] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """All after the rules."""
        return self.question.prompt.split("\n\n", 3)[3]

    @property
    def statement(self) -> str:
        """The answer to a question of yes or no."""
        patterns = {
            QuestionKind.FORWARD: r"Does (.+) hold afterwards",
            QuestionKind.BACKWARD: r"Is (.+) possible now, and",
            QuestionKind.INVERSE: r"Can the action be (.+)\?",
            QuestionKind.STATE: r"Does (.+) hold at the end",
            QuestionKind.APPLICABILITY: r"Is (.+) possible now",
            QuestionKind.WHY_NOT: r"Is its (requirement \d+) among",
            QuestionKind.COUNTERFACTUAL: r"what happens: (.+)\?",
            QuestionKind.VALIDATION: r"what happens: (.+)\?",
            QuestionKind.JUSTIFICATION: r"left out: (.+)\?",
            QuestionKind.REACHABILITY: r"Can (.+) become true",
            QuestionKind.NEXT_ACTION: r"begin with (.+)\?",
            QuestionKind.LANDMARKS: r"take (.+\))\?",
        }
        found = re.findall(patterns[self.question.kind], self.text)
        assert len(found) == 1, self.text
        return str(found[0])

    def listed(self) -> list[str]:
        """The lines with a dash, in order, before those that are asked about."""
        return re.findall(r"^- (.+)$", self.text.partition("\nWhich of these can")[0], re.MULTILINE)

    def numbered(self, part: int = 0) -> list[str]:
        """The lines with numbers, of one of the lists that have some."""
        lists: list[list[str]] = []
        for number, line in re.findall(r"^(\d+)\. (.+)$", self.text, re.MULTILINE):
            if number == "1":
                lists.append([])
            lists[-1].append(line)
        return lists[part]

    def is_right(self, text: str) -> bool:
        """Whether a choice is right, by itself."""
        world, kind = self.world, self.question.kind
        match kind:
            case QuestionKind.FORWARD | QuestionKind.STATE:
                return world.fact(text) in self.final()
            case QuestionKind.REACHABILITY:
                return any(world.fact(text) in facts for facts in self.reached()[0])
            case QuestionKind.BACKWARD | QuestionKind.INVERSE | QuestionKind.APPLICABILITY:
                return self.fits(world.act(text))
            case QuestionKind.WHY_NOT | QuestionKind.JUSTIFICATION:
                return text.split()[1] in self.right()
            case QuestionKind.COUNTERFACTUAL | QuestionKind.VALIDATION:
                (first, *_) = self.right()
                if "cannot be carried out" in text:
                    return text.startswith(f"{first} is the first")
                return ("goal" in first) if "not all goals hold" in text else first == "works"
            case QuestionKind.NEXT_ACTION | QuestionKind.LANDMARKS:
                return text in self.right()

    def final(self) -> Facts:
        """The facts that hold after the actions."""
        if self.question.kind is QuestionKind.FORWARD:
            (text,) = re.findall(r"Now (.+\)) is taken", self.text)
            plan = [text]
        else:
            plan = self.numbered()
        facts: Facts | None = self.world.start
        for step in plan:
            assert facts is not None
            facts = self.world.after(facts, self.world.act(step))
        assert facts is not None
        return facts

    def fits(self, act: Act) -> bool:
        """Whether an action is possible, and does what is asked for."""
        world = self.world
        after = world.after(world.start, act)
        if after is None or self.question.kind is QuestionKind.APPLICABILITY:
            return after is not None
        if self.question.kind is QuestionKind.INVERSE:
            changes = [line for line in self.listed() if line.removeprefix("not ") == line]
            gone = [line.removeprefix("not ") for line in self.listed() if line.startswith("not ")]
            before, now = world.seen(world.start), world.seen(after)
            return now - before == {world.fact(t) for t in changes} and before - now == {
                world.fact(t) for t in gone
            }
        literal = re.findall(r'"(.+?)" (?:holds?|does not hold)', self.text)[0]
        return (world.fact(literal) in after) is not literal.startswith("not ")

    def right(self) -> list[str]:
        """All right answers in open form."""
        world = self.world
        match self.question.kind:
            case QuestionKind.FORWARD:
                before, now = world.seen(world.start), world.seen(self.final())
                return [*map(world.said, now - before), *(f"not {world.said(f)}" for f in before - now)]
            case QuestionKind.STATE:
                if self.question.form is not QuestionForm.OPEN:
                    return []
                (name,) = re.findall(r"What holds of (\S+) at the end", self.text)
                about = world.scene.index[name]
                return [world.said(f) for f in world.seen(self.final()) if about in f.arguments]
            case QuestionKind.BACKWARD | QuestionKind.INVERSE:
                if self.question.form is not QuestionForm.OPEN:
                    return []
                return [world.said(act) for act in world.all_acts() if self.fits(act)]
            case QuestionKind.APPLICABILITY:
                return [text for text in self.listed() if self.fits(world.act(text))]
            case QuestionKind.WHY_NOT:
                (text,) = re.findall(r"At present (.+\)) is not possible", self.text)
                return [str(n) for n in world.unmet(world.start, world.act(text))]
            case QuestionKind.COUNTERFACTUAL:
                plan = [(n, world.act(text)) for n, text in enumerate(self.numbered(), 1)]
                assert world.outcome(plan, self.goals) == ["works"]
                return world.outcome(self.changed(plan), self.goals)
            case QuestionKind.VALIDATION:
                steps = enumerate(map(world.act, self.numbered(1)), 1)
                return world.outcome(steps, self.goals)
            case QuestionKind.JUSTIFICATION:
                plan = [(n, world.act(text)) for n, text in enumerate(self.numbered(), 1)]
                assert world.outcome(plan, self.goals) == ["works"]
                return [
                    str(n)
                    for n, _ in plan
                    if world.outcome([step for step in plan if step[0] != n], self.goals) == ["works"]
                ]
            case QuestionKind.REACHABILITY:
                reached = frozenset().union(*self.reached()[0])
                asked = self.text.partition("\nWhich of these can")[2]
                facts = re.findall(r"^- (.+)$", asked, re.MULTILINE)
                return [text for text in facts if world.fact(text) in reached]
            case QuestionKind.NEXT_ACTION:
                return self.first_steps()
            case QuestionKind.LANDMARKS:
                wanted = {world.fact(text) for text in self.numbered()}
                return [
                    text
                    for text in self.listed()
                    if not any(wanted <= facts for facts in self.reached(without=text)[0])
                ]

    def changed(self, plan: list[tuple[int, Act]]) -> list[tuple[int, Act]]:
        """The plan as it is carried out."""
        (change,) = re.findall(r"suppose that (.+), and that the rest", self.text)
        numbers = [int(n) for n in re.findall(r"steps? (\d+)", change)]
        place = numbers[0] - 1
        if "left out" in change:
            return plan[:place] + plan[place + 1 :]
        if "change places" in change:
            return [*plan[:place], plan[place + 1], plan[place], *plan[place + 2 :]]
        (text,) = re.findall(r", (.+\)) is carried out", change)
        return [*plan[:place], (0, self.world.act(text)), *plan[place:]]

    def acts(self, without: str | None = None) -> list[Act]:
        return [self.world.act(text) for text in self.listed() if text != without]

    def reached(
        self, start: Facts | None = None, without: str | None = None
    ) -> tuple[list[Facts], list[int]]:
        """Everything that the listed actions lead to, with how many it takes."""
        key = (start, without)
        if key not in self.known:
            self.known[key] = self.search(start, without)
        return self.known[key]

    def search(self, start: Facts | None, without: str | None) -> tuple[list[Facts], list[int]]:
        found = {self.world.start if start is None else start: 0}
        pending = list(found)
        for facts in pending:
            for act in self.acts(without):
                after = self.world.after(facts, act)
                if after is not None and after not in found:
                    found[after] = found[facts] + 1
                    pending.append(after)
        return list(found), list(found.values())

    def first_steps(self) -> list[str]:
        wanted = {self.world.fact(text) for text in self.numbered()}

        def distance(start: Facts) -> float:
            pairs = zip(*self.reached(start), strict=True)
            return min((depth for facts, depth in pairs if wanted <= facts), default=float("inf"))

        best = distance(self.world.start)
        assert best == self.question.depth
        found = []
        for act in self.acts():
            after = self.world.after(self.world.start, act)
            if after is not None and distance(after) == best - 1:
                found.append(self.world.said(act))
        return found
