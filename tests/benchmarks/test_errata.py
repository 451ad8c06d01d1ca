"""Every erratum has evidence, and its correction corrects the error."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

import eai.world as w
from by_path import module_at
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import DataError, InputError
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark, DataSet
from eai.benchmarks.errata import ApplicableErrata, _Erratum, load_all_errata, read_errata
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.logic.formula import Atom, Constant
from eai.logic.traversal import walk_subformulas
from eai.pddl.check import PddlViolationKind, check_problem
from eai.pddl.planning import PlannerChoice
from eai.results.batch import score_run
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.results.totals import RunTotals
from eai.tasks.goal_text import make_task
from eai.tasks.source import ErrataChoice, Source, find_errata_choice, use_tasks
from eai.world.execution import attempt_action
from eai.world.history import History
from oracle import MODELS, Oracle
from protocols import PROTOCOLS

VERSIONS = {1: "1+92cd0f75", 2: "2+2ce9dbe1", 3: "3+1210d2bc"}
"""Content of each version of the table: a changed correction needs a new version."""

CURRENT, NONE = ErrataChoice.CURRENT, ErrataChoice.NONE
ENTRIES = {entry.id: entry for entry in load_all_errata().entries}


def open_corrected_suite(
    store: DataPackStore, entry: _Erratum, ability: Ability, errata: ErrataChoice
) -> Suite:
    source = Source(store, planner=PlannerChoice.BUILT_IN, errata=errata)
    return open_suite(entry.domain, ability, source=source)


def does_gold_succeed(
    store: DataPackStore, entry: _Erratum, errata: ErrataChoice, task_id: str
) -> bool | None:
    """Whether the data set's own answer succeeds, or None if it is not counted."""
    suite = open_corrected_suite(store, entry, entry.abilities[0], errata)
    book = open_gold_answers(suite.benchmark, suite.ability, suite.source)
    verdict = suite.score(task_id, book[task_id].text)
    assert isinstance(verdict, PlanVerdict | OperatorVerdict)
    return verdict.success


def check_no_plan_exists(entry: _Erratum, store: DataPackStore) -> None:
    """An action that fills a hand never leaves an object in both hands that was in at most one."""
    (task_id,) = entry.tasks
    for ability in entry.abilities:
        suite = open_corrected_suite(store, entry, ability, NONE)
        start, domain = suite.tasks[task_id].initial, suite.benchmark.domain
        if ability is Ability.SUBGOAL_DECOMPOSITION:
            domain = suite.benchmark.subgoal_notation().get_domain_for_executing_subgoals()
        fill = [
            operator
            for operator in domain.operators
            if re.search(r"Add\(.{0,40}HOLDS_[LR]H", repr(operator.effects))
        ]
        assert {operator.name for operator in fill} <= {"GRAB", "SWITCH_HANDS"}
        agent, glass = start.scene.agent or 0, start.scene.index["water_glass.1000"]
        shut = ("INSIDE", (glass, start.scene.index["cupboard.229"]))
        others = [fact for fact in start.facts() if not fact.predicate.startswith("HOLDS") and fact != shut]
        near = [("NEXT_TO", pair) for pair in ((agent, glass), (glass, agent))]
        for held in ((), ("HOLDS_RH",), ("HOLDS_LH",)):
            before = start.scene.state([*others, *near, *((hand, (agent, glass)) for hand in held)])
            for operator in fill:
                after = attempt_action(domain, History(before), w.Action(operator.name, (glass,)))
                both = isinstance(after, w.State) and all(
                    after.has(hand, agent, glass) for hand in ("HOLDS_RH", "HOLDS_LH")
                )
                assert not both
                assert isinstance(after, w.State) or operator.name != "GRAB" or held
        assert does_gold_succeed(store, entry, NONE, task_id) is False
        assert (
            open_corrected_suite(store, entry, ability, CURRENT).score(task_id, "").excluded == entry.exclude
        )


def check_plans_need_ids(entry: _Erratum, store: DataPackStore) -> None:
    (ability,) = entry.abilities
    suite = open_corrected_suite(store, entry, ability, CURRENT)
    book = open_gold_answers(suite.benchmark, ability, suite.source)
    questions = suite.benchmark.official_prompts(ability, suite.source) or {}
    for task_id in entry.tasks:
        with_ids = book[task_id].text
        without = re.sub(r', "\d+"', "", with_ids)
        verdicts = [suite.score(task_id, text) for text in (with_ids, without)]
        assert [isinstance(verdict, PlanVerdict) and verdict.success for verdict in verdicts] == [
            True,
            False,
        ], task_id
        assert "its name and its id" in questions[task_id].user


def check_no_model_succeeds(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> list[PlanVerdict]:
    """Check that no published answer is right, and return the verdicts."""
    (ability,) = entry.abilities
    verdicts = score_model_answers(open_corrected_suite(store, entry, ability, CURRENT), entry, oracle)
    assert not any(verdict.success for verdict in verdicts)
    return verdicts


def check_questions_omit_the_seat(entry: _Erratum, store: DataPackStore) -> None:
    """In nine tasks, the character sits initially, and a plan without standing up fails."""
    (ability,) = entry.abilities
    for choice, unsaid in ((NONE, set(entry.tasks)), (CURRENT, set())):
        suite = open_corrected_suite(store, entry, ability, choice)
        questions = suite.benchmark.official_prompts(ability, suite.source) or {}
        seated = {
            i
            for i, task in suite.tasks.items()
            if task.scene.agent is not None and task.initial.has("SITTING", task.scene.agent)
        }
        assert len(seated) == 9
        assert {i for i in seated if "\ncharacter, states: ['SITTING']" not in questions[i].user} == unsaid
    book = open_gold_answers(suite.benchmark, ability, suite.source)
    for task_id in entry.tasks:
        gold = book[task_id].text
        verdicts = [score_plan(suite, task_id, text) for text in (gold, gold.replace('"STANDUP": [ ], ', ""))]
        assert [verdict.success for verdict in verdicts] == [True, False]


def check_no_model_stands_up(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> None:
    verdicts = check_no_model_succeeds(entry, store, oracle)
    details = [verdict.error.detail for verdict in verdicts if verdict.error is not None]
    assert details.count("the character is sitting or lying") == 14


def check_pouring_twice_fails(entry: _Erratum, store: DataPackStore) -> None:
    (ability,) = entry.abilities
    for choice, is_said in ((NONE, False), (CURRENT, True)):
        suite = open_corrected_suite(store, entry, ability, choice)
        questions = suite.benchmark.official_prompts(ability, suite.source) or {}
        for task_id in entry.tasks:
            assert "\nPOUR\nPOUR\n" in questions[task_id].user
            assert ("needs to be included only once" in questions[task_id].user) is is_said
    book = open_gold_answers(suite.benchmark, ability, suite.source)
    for task_id in entry.tasks:
        gold = book[task_id].text
        twice, number = re.subn(r'("POUR": \[.*?\])', r"\1, \1", gold)
        assert number == 1
        verdicts = [score_plan(suite, task_id, text) for text in (gold, twice)]
        assert [verdict.success for verdict in verdicts] == [True, False]


def check_models_pour_twice(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> None:
    check_no_model_succeeds(entry, store, oracle)
    pours = [
        len(re.findall(r"""['"]POUR\w*['"]\s*:""", text)) for _, text in read_model_answers(entry, oracle)
    ]
    assert (sum(number > 1 for number in pours), len(pours)) == (38, 45)


def check_questions_omit_pour(entry: _Erratum, store: DataPackStore) -> None:
    (ability,) = entry.abilities
    for choice, offered in ((NONE, False), (CURRENT, True)):
        suite = open_corrected_suite(store, entry, ability, choice)
        questions = suite.benchmark.official_prompts(ability, suite.source) or {}
        for task_id in entry.tasks:
            question = questions[task_id]
            assert ("\n| POUR | (obj1.id, obj2.id) |" in f"{question.system}{question.user}") is offered
            assert "\nPOUR\n" in question.user
            assert "| TOUCH | (obj1.id) |" in (question.system or "")
            assert does_gold_succeed(store, entry, choice, task_id) is True


def check_models_pour_one_object(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> None:
    check_no_model_succeeds(entry, store, oracle)
    texts = [text for _, text in read_model_answers(entry, oracle)]
    assert (sum(bool(re.search(r"POUR\([^,()]*\)", text)) for text in texts), len(texts)) == (39, 45)


def read_model_answers(entry: _Erratum, oracle: Oracle) -> list[tuple[str, str]]:
    """Return the published answers to the tasks of an entry on one ability of VirtualHome."""
    (ability,) = entry.abilities
    rows = [row for model in MODELS for row in oracle("virtualhome", ability.value, model)["tasks"]]
    answers = [(row["id"], row["llm_output"]) for row in rows if row["id"] in entry.tasks]
    assert len(answers) == len(MODELS) * len(entry.tasks)
    return answers


def score_model_answers(suite: Suite, entry: _Erratum, oracle: Oracle) -> list[PlanVerdict]:
    return [score_plan(suite, task_id, text) for task_id, text in read_model_answers(entry, oracle)]


def score_plan(suite: Suite, task_id: str, text: str) -> PlanVerdict:
    verdict = suite.score(task_id, text)
    assert isinstance(verdict, PlanVerdict)
    return verdict


def check_operator_has_a_hyphen(entry: _Erratum, store: DataPackStore) -> None:
    tasks = find_benchmark("behavior").operator_tasks(Source(store, errata=NONE))
    assert [i for i, task in tasks.items() if "slice-carvingknife" in task.operators] == list(entry.tasks)


def check_no_model_writes_the_hyphen(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> None:
    texts = behavior_answers(oracle, entry.tasks)
    assert len(texts) == 27
    assert sum("slice_carvingknife" in text for text in texts) == 26
    assert not any("slice-carvingknife" in text for text in texts)


def check_questions_name_other_operators(entry: _Erratum, store: DataPackStore) -> None:
    benchmark = find_benchmark("behavior")
    tasks = benchmark.operator_tasks(Source(store))
    for choice, all_right in ((NONE, 0), (CURRENT, 25)):
        source = Source(store, errata=choice)
        questions = benchmark.official_prompts(Ability.TRANSITION_MODELING, source) or {}
        right = [i for i in entry.tasks if heads(questions[i].user) == set(tasks[i].operators)]
        assert len(right) == all_right


def check_models_were_asked_for_scored_operators(
    entry: _Erratum, store: DataPackStore, oracle: Oracle
) -> None:
    tasks = find_benchmark("behavior").operator_tasks(Source(store))
    named = [
        set(re.findall(r":action ([\w-]+)", text)) == set(tasks[task_id].operators)
        for task_id in entry.tasks
        for text in behavior_answers(oracle, [task_id])
    ]
    assert (sum(named), len(named)) == (219, 225)


def check_problem_has_an_undeclared_object(entry: _Erratum, store: DataPackStore) -> None:
    for choice, offences in ((NONE, {PddlViolationKind.UNDECLARED_CONSTANT}), (CURRENT, set())):
        tasks = find_benchmark("behavior").operator_tasks(Source(store, errata=choice))
        for task_id in entry.tasks:
            task = tasks[task_id]
            assert {error.offence for error in check_problem(task.problem, task.domain.header)} == offences


def check_published_plan_fails(entry: _Erratum, store: DataPackStore) -> None:
    for task_id in entry.tasks:
        assert does_gold_succeed(store, entry, NONE, task_id) is False
        assert does_gold_succeed(store, entry, CURRENT, task_id) is True


def check_question_names_another_relation(entry: _Erratum, store: DataPackStore) -> None:
    """Only these questions about plans name predicates other than the scored ones."""
    (ability,) = entry.abilities
    for choice, others in ((NONE, set(entry.tasks)), (CURRENT, set())):
        suite = open_corrected_suite(store, entry, ability, choice)
        questions = suite.benchmark.official_prompts(ability, suite.source) or {}
        predicates = {predicate.name for predicate in suite.benchmark.domain.vocabulary.derived}
        differing = set()
        for task_id, task in suite.tasks.items():
            scored = [p for goal in task.goals for p in walk_subformulas(goal.formula) if isinstance(p, Atom)]
            goals = (
                questions[task_id]
                .user.rpartition("target environment state:")[2]
                .partition("interactable")[0]
            )
            words = [word for word in re.findall(r"'(\w+)'", goals) if word in predicates]
            if sorted(words) != sorted(atom.predicate for atom in scored):
                differing.add(task_id)
        assert differing == others
    for task_id in entry.tasks:
        assert does_gold_succeed(store, entry, NONE, task_id) is True


def check_no_model_means_the_other_relation(entry: _Erratum, store: DataPackStore, oracle: Oracle) -> None:
    (ability,) = entry.abilities
    suite = open_corrected_suite(store, entry, ability, CURRENT)
    for task_id in entry.tasks:
        for model in MODELS:
            rows = oracle("behavior", "action_sequencing", model)["records"]
            (text,) = [row["response"] for row in rows if row["identifier"] == task_id]
            assert not score_plan(suite, task_id, text).success


EVIDENCE: Mapping[str, Callable[[_Erratum, DataPackStore], None]] = {
    "glass-in-both-hands": check_no_plan_exists,
    "two-lights-of-one-name": check_plans_need_ids,
    "things-of-one-name": check_plans_need_ids,
    "unsaid-seat": check_questions_omit_the_seat,
    "pour-twice": check_pouring_twice_fails,
    "pour-not-offered": check_questions_omit_pour,
    "slice-carvingknife": check_operator_has_a_hyphen,
    "other-operators-asked-for": check_questions_name_other_operators,
    "ontop-for-touching": check_question_names_another_relation,
    "undeclared-cleansing-agent": check_problem_has_an_undeclared_object,
    **{name: check_published_plan_fails for name in ENTRIES if name.startswith("plan-of-")},
}
"""Check of the evidence in the data set, by erratum."""

EVIDENCE_OF_MODELS: Mapping[str, Callable[[_Erratum, DataPackStore, Oracle], object]] = {
    "two-lights-of-one-name": check_no_model_succeeds,
    "things-of-one-name": check_no_model_succeeds,
    "unsaid-seat": check_no_model_stands_up,
    "pour-twice": check_models_pour_twice,
    "pour-not-offered": check_models_pour_one_object,
    "slice-carvingknife": check_no_model_writes_the_hyphen,
    "other-operators-asked-for": check_models_were_asked_for_scored_operators,
    "ontop-for-touching": check_no_model_means_the_other_relation,
}
"""Check of the evidence in the published models' answers, by erratum."""


def behavior_answers(oracle: Oracle, task_ids: object) -> list[str]:
    assert isinstance(task_ids, list | tuple)
    rows = [row for model in MODELS for row in oracle("behavior", "transition_modeling", model)["records"]]
    return [row["response"] for row in rows if row["identifier"] in task_ids]


def heads(question: str) -> set[str]:
    asked = question.rpartition("Action to be finished:\n")[2].partition("\nOutput:")[0]
    return set(re.findall(r"\(:action ([^\s()]+)", asked))


@pytest.mark.parametrize("name", list(ENTRIES))
def test_an_erratum_has_evidence_in_the_data_set(name: str, data_store: DataPackStore) -> None:
    EVIDENCE[name](ENTRIES[name], data_store)


@pytest.mark.parametrize("name", EVIDENCE_OF_MODELS)
def test_an_erratum_has_evidence_in_published_answers(
    name: str, data_store: DataPackStore, oracle: Oracle
) -> None:
    EVIDENCE_OF_MODELS[name](ENTRIES[name], data_store, oracle)


def test_each_version_of_the_table_has_fixed_corrections() -> None:
    number = int(load_all_errata().version.partition("+")[0])
    assert VERSIONS[number] == load_all_errata().version, "state the new version in errata.toml and here"
    assert {entry.since for entry in ENTRIES.values()} <= set(VERSIONS)


def test_the_page_of_errata_equals_the_table() -> None:
    tool = module_at("tools/errata_page.py")
    assert tool.PAGE.read_text(encoding="utf-8") == tool.make_page(), "run: python tools/errata_page.py"


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_only_the_default_protocol_uses_errata(
    data_store: DataPackStore, domain: str, ability: Ability
) -> None:
    source = Source(data_store, planner=PlannerChoice.NONE)
    version = load_all_errata().version
    opened = {each: open_suite(domain, ability, each, source=source) for each in PROTOCOLS}
    for protocol, suite in opened.items():
        is_default = protocol is Protocol.STRICT
        assert suite.errata.version == (version if is_default else "")
        used = suite.errata.find_errata_of_task(ability, suite.task_ids[0])
        assert used == (ApplicableErrata(version) if is_default else None)


HEAD = """
version = 2
[[erratum]]
id = "dark"
domain = "lamps"
abilities = ["action_sequencing"]
tasks = ["light"]
since = 2
wrong = "w"
evidence = "e"
"""


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEAD + 'exclud = "typo"', "exclud"),
        (
            HEAD.replace("since = 2", "since = 3") + 'exclude = "x"',
            "dark is of version 3, above the version 2 of the table",
        ),
        (HEAD.replace("action_sequencing", "dancing") + 'exclude = "x"', "abilities"),
        (HEAD.replace('wrong = "w"\n', "") + 'exclude = "x"', "wrong"),
        (HEAD, "dark: expected one correction, found none"),
        (
            HEAD + 'exclude = "x"\nasks_scored = true',
            "dark: expected one correction, found exclude, asks_scored",
        ),
    ],
)
def test_a_table_with_an_invalid_entry_is_an_error(text: str, told: str) -> None:
    with pytest.raises(DataError, match=re.escape(told)):
        read_errata(text)


def benchmark_with(correction: str) -> Benchmark:
    x, lit = w.Variable("x"), w.Predicate("lit", 1)
    press = w.Operator("PRESS", (x,), (w.additional_step(~lit(x), "{x} is lit"),), (w.Add(lit(x)),))
    domain = w.Domain("lamps", w.Vocabulary((lit,)), (press,))
    start = w.Scene(domain.vocabulary, [w.WorldObject("lamp", "lamp")]).state([])
    tasks = [make_task(name, "Light.", start, lit(Constant("lamp"))) for name in ("light", "other")]
    tasks[0] = replace(tasks[0], script=(w.Action("PRES", (0,)), w.Action("PRESS", (0,))))
    return Benchmark("lamps", domain, use_tasks(*tasks), data=DataSet(errata=read_errata(HEAD + correction)))


def test_an_excluded_task_has_a_record_but_is_not_in_the_denominator() -> None:
    suite = open_suite(benchmark_with('exclude = "the bulb is broken"'), Ability.ACTION_SEQUENCING)
    answer = json.dumps([{"action": "PRESS", "object": "lamp"}])
    answers = ResponseFile("m", tuple(Response(i, answer) for i in suite.task_ids))
    records = score_run(suite, answers, {}, ScoringOptions())
    assert [record.verdict.excluded for record in records] == ["the bulb is broken", None]
    assert [record.errata and record.errata.entries for record in records] == [("dark",), ()]
    effect = RunTotals.from_records(records).errata
    assert effect is not None
    assert (effect.tasks, effect.scored, effect.left_out, effect.corrected) == (2, 1, ("light",), ())
    assert str(effect.remark_on_errata).startswith("Of 2 tasks, 1 left out, because")
    off = open_suite(suite.benchmark, suite.ability, source=Source(errata=NONE))
    assert RunTotals.from_records(score_run(off, answers, {}, ScoringOptions())).errata is None
    assert off.score("light", answer).excluded is None


@pytest.mark.parametrize(
    ("edits", "script"),
    [
        ('[{ step = 0, was = ["PRES lamp"], now = [] }]', ["PRESS"]),
        ('[{ step = 1, was = [], now = ["PRESS lamp"] }]', ["PRES", "PRESS", "PRESS"]),
        (
            '[{ step = 0, was = ["PRES lamp"], now = ["A lamp", "B lamp"] }, '
            '{ step = 1, was = ["PRESS lamp"], now = ["C lamp"] }]',
            ["A", "B", "C"],
        ),
    ],
)
def test_corrections_refer_to_step_numbers_of_the_published_plan(edits: str, script: list[str]) -> None:
    tasks = benchmark_with(f"plan = {edits}").tasks(Source())
    assert [action.operator for action in tasks["light"].script] == script


def test_a_correction_of_different_data_is_an_error() -> None:
    tasks = benchmark_with('plan = [{ step = 0, was = ["PRESS lamp"], now = [] }]').tasks(Source())
    with pytest.raises(DataError, match="dark: the data is of another version, because step 0 of"):
        tasks["light"]


def test_an_unknown_choice_is_an_error() -> None:
    with pytest.raises(InputError, match=r"'nome' is no choice of errata.*did you mean"):
        find_errata_choice("nome")
