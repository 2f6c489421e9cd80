"""Every quantity in the table of signals can be used in conditions and by user models."""

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse
from heavylift.nodes.scene.construction import build_machines
from heavylift.nodes.scene.construction.signals import Conditions
from heavylift.nodes.scene.language import QUANTITIES, PhraseError, read_condition
from heavylift.nodes.scene.text import Mark, SourceText
from lifting import cranes, slings

JIB = {  # words -> model that watches, quantity of the kernel
    "radius of jib main >= 25 m": ("jib", "radius"),
    "moment of jib >= 90 %": ("jib", "moment"),
    "load of jib main >= 10 t": ("jib", "load"),
    "load of jib >= 75 %": ("jib", "moment"),
    "tension of legs.sling-1 >= 75 %": ("jib", "load"),
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
    "load of west >= 75 %": ("west", "load"),
    "load of west upper >= 300 t": ("west", "load"),
    "off-lead of loader-1 >= 2 deg": ("west", "off-lead"),
    "gap west east <= 3 m": ("west", "gap"),
    "wind >= 12 m/s": ("wind", "wind"),
}
NONE = {
    "radius of west H1 >= 20 m": "there is no 'west H1' with radius: nothing in this scene has radius",
    "moment of west H1 >= 90 %": "there is no 'west H1' with moment: nothing in this scene has moment",
    "off-lead of north H1 >= 2 deg": "there is no 'north H1' with off-lead: known: east.H1",
    "load of nest >= 75 %": "there is no 'nest' with a rated load: did you mean 'west'?",
    "gap west store <= 3 m": "there is no 'store' with gap: known: block, east, west",
}
MISSPELT = {
    "swing of jib main >= 1 deg": "after 'swing' 'along' or 'across' must follow, not 'of'",
    "gap west <= 3 m": "a second name is expected here, not '<='",
    "load >= 3 t": "'load' needs 'of' and a name, such as 'load of loader-1'",
    "moment of jib >= 3 t": "'3 t' is not a valid ratio: 't' is a unit of mass",
}


@pytest.fixture(scope="module")
def read():
    """What a condition becomes in a bundled scene: a crossing, or the sentences of its faults."""
    scenes = {name: load(name) for name in ("jib", "wind-tandem")}

    def found(name, words):
        source = SourceText("scene.yaml")
        path = ("command",)
        source.keys[path] = source.values[path] = Mark("scene.yaml", 1, 1, words)
        builder = build_machines(source, scenes[name].scene)
        builder.machines = [*scenes[name].plan.machines]
        term = Conditions(builder).read(path, read_condition(words))
        return [f"{f.sentence}: {f.hint}" for f in source.faults] or term

    return found


@pytest.mark.parametrize(
    ("scene", "words", "told"),
    [("jib", *item) for item in JIB.items()] + [("wind-tandem", *item) for item in GOLIATHS.items()],
)
def test_each_condition_in_an_action_list_is_a_threshold_of_a_signal(read, scene, words, told):
    term = read(scene, words)
    assert (term.model, term.threshold.quantity) == told


def test_every_quantity_in_the_table_of_signals_can_be_used_in_a_condition():
    text = [words for words in (*JIB, *GOLIATHS)]
    assert not [quantity for quantity in QUANTITIES if not any(words.startswith(quantity) for words in text)]


@pytest.mark.parametrize(("words", "sentence"), NONE.items())
def test_a_condition_on_an_unknown_signal_is_reported(read, words, sentence):
    (message,) = read("wind-tandem", words)
    assert message.startswith(sentence)


def test_a_condition_on_wind_in_a_scene_without_wind_is_reported(read):
    assert read("jib", "wind >= 12 m/s") == ["no wind blows in this scene: add 'wind': "]


@pytest.mark.parametrize(("words", "sentence"), MISSPELT.items())
def test_a_condition_with_a_misspelt_signal_is_reported(words, sentence):
    with pytest.raises(PhraseError, match=sentence):
        read_condition(words)


LIMITED = "limits: {{signals: [{}]}}\n"


def limited(*signals):
    text = f"extends: wind-tandem\nname: limited\n{LIMITED.format(', '.join(signals))}end: 200 s\n"
    return parse(text, "scene.yaml", passing=True)


def test_limits_and_conditions_use_the_same_signals():
    """What the scene limits by the table's words comes to the values of the rows that are always judged."""
    scene = limited(
        "load of east H2 <= 100 t", "off-lead of west H1 <= 0.01 deg", "wind <= 9 m/s", "gap west east >= 3 m",
        "height difference west.H1 east.H1 <= 0.5 m",
    )  # fmt: skip
    signals = {use.limit.subject: use for use in scene.uses if use.limit.quantity == "signal"}
    others = {(use.limit.quantity, use.limit.subject): use for use in scene.uses}
    assert signals["load of east H2"].value == pytest.approx(others["hook load", "east.H2"].value, rel=1e-12)
    assert signals["wind"].value == pytest.approx(max(f.value for f in (others["wind", "all"],)), rel=0.05)
    along, across = (others[f"off-lead {distance}", "west.H1"].value for distance in ("along", "across"))
    assert max(along, across) <= signals["off-lead of west H1"].value <= along + across
    machines = {machine.name: machine for machine in cranes(scene.plan)}
    (west, east), width = (machines[name].actuators[0].start for name in ("west", "east")), 34.0
    assert signals["gap west east"].value == pytest.approx(east - west - width, abs=1e-3)
    message = [f.sentence for f in scene.findings if f.quantity == "signal"]
    assert "gap west east would be 2.00 m; at least 3.00 m is needed (the scene)" in message
    assert "load of east H2 would be 171.5 t, 172 %; 100.0 t is allowed (the scene)" in message
    assert len(message) == 4, "the hooks are level"


def test_a_condition_on_a_load_in_per_cent_uses_the_utilisation_of_the_check():
    """What `check` tells of a load in per cent is what a condition compares."""
    subjects = ("east H2", "east upper", "east", "loader-1", "loader-1.sling-1")
    sets = {"all slings": "", "loader-1 slings": "loader-1."}
    message = [f"{'tension' if 'sling' in x else 'load'} of {x} <= 30 %" for x in (*subjects, *sets)]
    scene = limited(*message)
    uses = {use.limit.subject: use for use in scene.uses if use.limit.quantity == "signal"}
    kinds = ("hook load", "trolley load", "tandem load", "loader load", "sling tension")
    for x, kind in zip(subjects, kinds, strict=True):
        (row,) = (u for u in scene.uses if u.limit.quantity == kind and u.limit.subject in (x, x.replace(" ", ".")))
        found = uses[f"{'tension' if 'sling' in x else 'load'} of {x}"]
        assert found.value == pytest.approx(row.use, rel=1e-12)
    slings = {u.limit.subject: u.use for u in scene.uses if u.limit.quantity == "sling tension"}
    for words, front in sets.items():
        most = max(use for sling, use in slings.items() if sling.startswith(front))
        assert uses[f"tension of {words}"].value == pytest.approx(most, rel=1e-12), "of a set, the most used one"
    message = [f.sentence for f in scene.findings if f.quantity == "signal"]
    assert "load of east H2 would be 38 %; 30 % is allowed (the scene)" in message


CHART = "[[60 m, 400 t], [82 m, 300 t], [140 m, 120 t]]"


def test_a_condition_on_a_load_in_per_cent_of_a_chart_uses_the_capacity_at_the_trolley_position():
    """The load is the same in every place of the trolley; what it may be there, the chart interpolates."""
    scene = parse(
        f"extends: lift\nname: charted\ncranes: {{crane: {{capacity chart: {CHART}}}}}\n"
        "limits: {signals: [load of crane H3 <= 90 %]}\nfactors: {rigging: 0 t}\n",
        "scene.yaml",
        passing=True,
    )
    (row,) = (u for u in scene.uses if (u.limit.quantity, u.limit.subject) == ("hook load", "crane.H3"))
    (use,) = (u for u in scene.uses if u.limit.quantity == "signal")
    assert use.value == pytest.approx(row.use, rel=1e-12)
    last = scene.statics.states[-1]
    load = last.tensions["crane.H3"] / 9.80665 - 25e3
    y = last.poses["crane.lower"][0][1]
    allowed = 300e3 - 180e3 * (y - 82.0) / 58.0
    assert y == pytest.approx(83.0)
    assert max(use.value, load / allowed) == pytest.approx(use.value, rel=1e-9)
    assert use.value == pytest.approx(load / allowed, rel=0.02), "lifting off differs little"


@pytest.mark.parametrize(
    ("words", "quantity"),
    [
        ("load of crane H1 in %", "load"),
        ("load of crane H3 in %", "use by place"),
        ("tension of all slings in %", "use"),
    ],
)
def test_a_user_model_can_receive_a_load_as_a_percentage_of_its_limit(words, quantity):
    """What a condition with the same words and a value in % compares."""
    chart = f"cranes: {{crane: {{capacity chart: {CHART}}}}}\n" if "H3" in words else ""
    text = (
        f"extends: lift\nname: heard\n{chart}" + "actions: [{wait: 1 s, when: WORDS >= 90 %}]\nmodels: {own: {model: "
    )
    text += "heavylift.nodes.zoo.anti_sway:Damper, period: 1 s, signals: {swing: WORDS in %}, "
    text += "orders: {speed: crane lower trolley}, parameters: {distance: 1 m, speed: 1 m/s, ramp: 1 m/s2}}}\n"
    plan = parse(text.replace("WORDS", words.removesuffix(" in %")), "scene.yaml", passing=True, followed=False).plan
    heard, guard = plan.models[0].signals["swing"], plan.actions[0].when.threshold
    assert heard.quantity == guard.quantity == quantity
    assert (heard.ropes, heard.numbers, heard.point) == (guard.ropes, guard.numbers, guard.point)


def test_an_interlock_on_a_load_in_per_cent_uses_the_utilisation_of_each_hook():
    """Of its own rated load, 420 t, less its hook block of 25 t."""
    interlock = "interlocks: {share: {when: load of any hook >= 95 %, stops: [hoist], on: west}}"
    (found,) = parse(
        f"extends: wind-tandem\nname: share\n{interlock}\n", "scene.yaml", passing=True, followed=False
    ).plan.interlocks
    assert found.value == 0.95
    g = 9.80665
    assert {guard.numbers for guard in found.guards} == {(1.0 / (g * 420e3), 25e3 / 420e3)}


@pytest.mark.parametrize(("value", "quantity"), [("95 %", "load"), ("1 MN", "tension")])
def test_an_interlock_can_monitor_each_of_several_slings(value, quantity):
    """Shares refer to the limit of each sling at rest, forces to all slings."""
    interlock = f"interlocks: {{snatch: {{when: tension of any sling >= {value}, stops: [hoist], on: west}}}}"
    plan = parse(f"extends: wind-tandem\nname: share\n{interlock}\n", "scene.yaml", passing=True, followed=False).plan
    (found,) = plan.interlocks
    assert sorted(guard.ropes[0] for guard in found.guards) == sorted(slings(plan))
    assert {guard.quantity for guard in found.guards} == {quantity}
    rated = {limit.subject: limit.value for limit in plan.limits if limit.quantity == "sling tension"}
    for guard in found.guards:
        assert guard.numbers == (pytest.approx((1.0 / rated[guard.ropes[0]], 0.0)) if quantity == "load" else ())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("angle <= 3 deg", "a limit is one of places, ropes, hooks or the wind"),
        ("all slings taut", "a limit is one of places, ropes, hooks or the wind"),
        ("gap west nord >= 1 m", "there is no 'nord' with gap"),
        ("load of west H1 <= 3 m", "'3 m' is not a valid mass"),
    ],
)
def test_a_limit_on_a_signal_that_cannot_be_limited_is_reported(words, sentence):
    with pytest.raises(SceneError) as error:
        limited(words)
    assert sentence in str(error.value)
    assert "scene.yaml:3:" in str(error.value)
