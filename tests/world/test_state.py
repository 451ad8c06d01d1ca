from __future__ import annotations

from eai.world.state import Scene, WorldObject
from eai.world.vocabulary import Vocabulary


def test_objects_come_by_category_in_the_order_of_the_scene() -> None:
    things = (WorldObject("b", "cup"), WorldObject("box", "box"), WorldObject("a", "cup"))
    scene = Scene(Vocabulary(()), things)
    assert scene.named("cup") == ("b", "a")
    assert scene.named(None) == ("b", "box", "a")
    assert scene.named("car") == ()
