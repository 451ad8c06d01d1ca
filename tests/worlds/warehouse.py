"""A warehouse: a forklift moves pallets, charges and loads a truck; eight operators, a predicate of three."""

import eai
from eai.world import (
    AGENT,
    ANYTHING,
    Add,
    DefinedPredicate,
    Delete,
    Domain,
    Exists,
    ForEach,
    Let,
    Operator,
    Predicate,
    Scene,
    Variable,
    Vocabulary,
    additional_step,
    affordance,
    is_a,
    missing_step,
)

x, y, place, other = Variable("x"), Variable("y"), Variable("place"), Variable("other")
at, on, loaded = Predicate("at", 2), Predicate("on", 2), Predicate("loaded", 3)
lifted, is_open, scanned, charged = (Predicate(n, 1) for n in ("lifted", "is_open", "scanned", "charged"))
alarm = Predicate("alarm", 0)
road = Predicate("road", 2, static=True)
here = DefinedPredicate("here", (x,), Exists(place, at(AGENT, place) & at(x, place)))
BESIDE = missing_step(here(x), "the forklift is not beside {x}")
FREE = missing_step(~Exists(other, lifted(other)), "the fork is not free")
PALLET = affordance(is_a(x, "pallet"), "{x} is no pallet")
DOOR = affordance(is_a(x, "truck"), "{x} has no door")

operators = (
    Operator(
        "DRIVE",
        (x,),
        (
            affordance(is_a(x, "bay", "dock"), "{x} is no place"),
            additional_step(~at(AGENT, x), "the forklift is at {x} already"),
            missing_step(Exists(place, at(AGENT, place) & road(place, x)), "no road leads to {x}"),
            missing_step(charged(AGENT), "the battery is empty"),
        ),
        (
            Delete(at(AGENT, ANYTHING)),
            Add(at(AGENT, x)),
            ForEach(y, lifted(y), (Delete(at(y, ANYTHING)), Add(at(y, x)))),
        ),
    ),
    Operator("LIFT", (x,), (PALLET, BESIDE, FREE), (Add(lifted(x)), Delete(on(x, ANYTHING)))),
    Operator("LOWER", (x,), (missing_step(lifted(x), "{x} is not lifted"),), (Delete(lifted(x)),)),
    Operator(
        "STACK",
        (x, y),
        (
            affordance(is_a(y, "pallet"), "{y} is no pallet"),
            missing_step(lifted(x), "{x} is not lifted"),
            missing_step(here(y), "the forklift is not beside {y}"),
        ),
        (Delete(lifted(x)), Add(on(x, y))),
    ),
    Operator("OPEN", (x,), (DOOR, additional_step(~is_open(x), "{x} is open"), BESIDE), (Add(is_open(x)),)),
    Operator(
        "SCAN", (x,), (PALLET, additional_step(~scanned(x), "{x} is scanned"), BESIDE), (Add(scanned(x)),)
    ),
    Operator(
        "LOAD",
        (x, y),
        (
            missing_step(lifted(x), "{x} is not lifted"),
            affordance(is_a(y, "truck"), "{y} is no truck"),
            missing_step(here(y), "the forklift is not beside {y}"),
            missing_step(is_open(y), "{y} is closed"),
        ),
        (
            Let(place, at(AGENT, place), (Add(loaded(x, y, place)),)),
            Delete(lifted(x)),
            Delete(at(x, ANYTHING)),
        ),
    ),
    Operator("SILENCE", (), (additional_step(alarm(), "it is quiet"),), (Delete(alarm()),)),
)
predicates = (at, on, loaded, lifted, is_open, scanned, charged, alarm, road)
domain = Domain("warehouse", Vocabulary(predicates, (here,)), operators)

kinds = {"forklift": "forklift", "bay_1": "bay", "bay_2": "bay", "dock": "dock", "truck": "truck"}
kinds |= {"crate": "pallet", "drum": "pallet"}
scene = Scene(domain.vocabulary, kinds, agent="forklift")
roads = [
    f"road({a}, {b})"
    for a, b in (("bay_1", "bay_2"), ("bay_2", "bay_1"), ("bay_2", "dock"), ("dock", "bay_2"))
]
places = ["at(forklift, bay_1)", "at(crate, bay_1)", "at(drum, bay_2)", "at(truck, dock)"]
start = scene.state([*roads, *places, "charged(forklift)", "alarm()"])
warehouse = eai.Benchmark(
    "warehouse",
    domain,
    eai.use_tasks(
        eai.make_task("ship", "Load the crate onto the truck.", start, "loaded(crate, truck, dock)"),
        eai.make_task(
            "stack", "Stack the crate on the drum.", start, "on(crate, drum) and not lifted(crate)"
        ),
        eai.make_task(
            "audit",
            "Scan all pallets and silence the alarm.",
            start,
            "forall p: pallet. (scanned(p))",
            "not alarm()",
        ),
    ),
)
