"""Every quantity of the table is a signal of what has it: in conditions, and in the models that listen."""

import pytest
from heavylift.nodes.scene import load
from heavylift.nodes.scene.construction.machines import build_machines
from heavylift.nodes.scene.construction.signals import Conditions
from heavylift.nodes.scene.language.grammar import read_condition
from heavylift.nodes.scene.language.phrases import PhraseError
from heavylift.nodes.scene.language.quantities import QUANTITIES
from heavylift.nodes.scene.text.source import Mark, Source

JIB = {  # words -> model that watches, quantity of the kernel
    "radius of jib main >= 25 m": ("jib", "radius"),
    "moment of jib >= 90 %": ("jib", "moment"),
    "load of jib main >= 10 t": ("jib", "load"),
    "off-lead of jib.main >= 1 deg": ("jib", "off-lead"),
    "swing along of legs.sling-1 <= 1 deg": ("jib", "swing along"),
    "swing across of jib main <= 1 deg": ("jib", "swing across"),
    "height difference jib.main block >= 10 m": ("jib", "height difference"),
    "height of jib main >= 10 m": ("jib", "height"),
    "height <= 3 m": ("block", "height"),
    "angle >= 3 deg": ("block", "angle"),
    "gap jib.boom block <= 2 m": ("jib", "gap"),
    "tension of jib main >= 100 kN": ("jib", "tension"),
    "length of jib.main >= 10 m": ("jib", "length"),
    "position of jib.luffing >= 40 deg": ("jib", "joint"),
    "speed of jib.slewing >= 1 deg/s": ("jib", "speed"),
}
GOLIATHS = {
    "load of west H1 >= 300 t": ("west", "load"),
    "off-lead of loader-1 >= 2 deg": ("west", "off-lead"),
    "gap west east <= 3 m": ("west", "gap"),
    "wind >= 12 m/s": ("wind", "wind"),
}
NONE = {
    "radius of west H1 >= 20 m": "there is no 'west H1' with radius: nothing in this scene has radius",
    "moment of west H1 >= 90 %": "there is no 'west H1' with moment: nothing in this scene has moment",
    "off-lead of north H1 >= 2 deg": "there is no 'north H1' with off-lead: known: loader-1.sling-1",
    "gap west store <= 3 m": "there is no 'store' with gap: known: block, east, west",
}
MISSPELT = {
    "swing of jib main >= 1 deg": "after 'swing' 'along' or 'across' must follow, not 'of'",
    "gap west <= 3 m": "a second name must stand here, not '<='",
    "load >= 3 t": "'load' needs 'of' and a name, such as 'load of loader-1'",
    "moment of jib >= 3 t": "'3 t' is no ratio: 't' is a unit of mass",
}


@pytest.fixture(scope="module")
def read():
    """What a condition becomes in a bundled scene: a crossing, or the sentences of its faults."""
    scenes = {name: load(name) for name in ("jib", "wind-tandem")}

    def found(name, words):
        source = Source("scene.yaml")
        path = ("command",)
        source.keys[path] = source.values[path] = Mark("scene.yaml", 1, 1, words)
        yard = build_machines(source, scenes[name].scene)
        term = Conditions(yard, scenes[name].plan.mechanisms).read(path, read_condition(words))
        return [f"{f.sentence}: {f.hint}" for f in source.faults] or term

    return found


@pytest.mark.parametrize(
    ("scene", "words", "told"),
    [("jib", *item) for item in JIB.items()] + [("wind-tandem", *item) for item in GOLIATHS.items()],
)
def test_a_condition_is_a_guard_over_a_signal(read, scene, words, told):
    term = read(scene, words)
    assert (term.model, term.threshold.quantity) == told


def test_every_row_of_the_table_is_among_these():
    said = [words for words in (*JIB, *GOLIATHS)]
    assert not [quantity for quantity in QUANTITIES if not any(words.startswith(quantity) for words in said)]


@pytest.mark.parametrize(("words", "sentence"), NONE.items())
def test_what_nothing_has_is_told(read, words, sentence):
    (told,) = read("wind-tandem", words)
    assert told.startswith(sentence)


def test_no_wind_is_told(read):
    assert read("jib", "wind >= 12 m/s") == ["no wind blows in this scene: add 'wind': "]


@pytest.mark.parametrize(("words", "sentence"), MISSPELT.items())
def test_what_is_misspelt_is_told(words, sentence):
    with pytest.raises(PhraseError, match=sentence):
        read_condition(words)
