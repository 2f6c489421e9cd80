"""Items of a description that were checked before are not checked again; faults in new items are found."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, System
from heavylift.kernel.model import check_description, checks

ROD = Body("rod", 2.0, com=(0.0, 0.0, -0.5), inertia=((0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1)))
HINGE = Joint("hinge", "revolute", "world", "rod", axis=(0.0, 1.0, 0.0))
GOOD = System((ROD,), (HINGE,))


def with_body(**changed: object) -> System:
    return replace(GOOD, bodies=(replace(ROD, **changed),))


def test_a_changed_system_is_validated_again_only_where_it_differs_from_the_previous_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    check_description(GOOD)
    seen: list[str] = []
    plain = checks._check_item
    monkeypatch.setattr(checks, "_check_item", lambda x: (seen.append(x.name), plain(x))[1])
    check_description(with_body(mass=2.000001))
    assert seen == ["rod"]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"mass": nan}, "mass is nan"),
        ({"mass": inf}, "mass is inf"),
        ({"mass": "2"}, "mass is '2'"),
        ({"inertia": ((0.2, 0.1, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1))}, "must be a symmetric matrix"),
    ],
)
def test_an_invalid_description_of_a_system_is_refused_every_time_it_is_checked(
    wrong: dict[str, object], sentence: str
) -> None:
    for _ in range(2):
        check_description(GOOD)
        with pytest.raises(KernelError, match=sentence):
            check_description(with_body(**wrong))


def test_python_lists_in_a_description_of_a_system_are_converted_to_tuples() -> None:
    check_description(GOOD)
    for _ in range(2):
        (body,) = check_description(with_body(com=[0.0, 0.0, -0.5])).bodies
        assert body == ROD
        assert type(body.com) is tuple
