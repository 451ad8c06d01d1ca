from __future__ import annotations

from eai.world.state import Scene, SceneObjects, WorldObject
from eai.world.vocabulary import Vocabulary


def test_objects_come_by_category_in_the_order_of_the_scene() -> None:
    things = (WorldObject("b", "cup"), WorldObject("box", "box"), WorldObject("a", "cup"))
    objects = SceneObjects(Scene(Vocabulary(()), things))
    assert objects.objects("cup") == ("b", "a")
    assert objects.objects(None) == ("b", "box", "a")
    assert objects.objects("car") == ()
