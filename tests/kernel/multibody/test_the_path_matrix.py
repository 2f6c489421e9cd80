"""The path matrix follows from the graph of joints, and the balance of each body from the path matrix (C19a)."""

import json
from pathlib import Path

import numpy as np
from heavylift.kernel.description import WORLD, Body, Joint, System
from heavylift.kernel.equations import equations
from heavylift.kernel.multibody import build_graph, children_of, path_matrix
from hypothesis import given, settings, strategies as st

FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
C19A = next(x for x in FORMS if x["id"] == "C19a")
ARM = C19A["given"]["parent"]

trees = st.integers(1, 40).flatmap(lambda n: st.tuples(*(st.integers(-1, i - 1) for i in range(n))))


def tree(parents, order):
    """A mechanism of hinged bodies b0, b1, ... listed in `order`."""
    bodies = [Body(f"b{i}", 1.0, (1.0, 0.0, 0.0)) for i in order]
    joints = [Joint(f"j{i}", "revolute", WORLD if parents[i] < 0 else f"b{parents[i]}", f"b{i}") for i in order]
    return System(tuple(bodies), tuple(reversed(joints)))


def test_the_four_link_arm_has_its_published_path_matrix():
    T = path_matrix(ARM)
    assert T.tolist() == C19A["expected"]["T"]
    assert np.linalg.inv(T).T.round().astype(int).tolist() == C19A["expected"]["T_inv_transpose"]


def test_the_published_recursion_for_the_inverse_path_matrix_if_read_literally_subtracts_a_joint_twice():
    """As a running sum the third joint of the arm would be subtracted twice from the first body."""
    T = path_matrix(ARM)
    assert [children_of(T, i) for i in range(4)] == [[1, 2], [], [3], []]
    first = [next((j for j in range(1, 4) if T[k, j]), None) for k in range(4) if T[k, 0]]
    literal = [1, *(-first.count(j) for j in (1, 2, 3))]
    assert literal == C19A["expected"]["literal_reading_row1"]


@settings(max_examples=200, deadline=None, derandomize=True)
@given(trees, st.randoms(use_true_random=False))
def test_path_matrices_of_random_trees_are_regular_for_any_order_of_the_bodies(parents, random):
    order = list(range(len(parents)))
    random.shuffle(order)
    graph = build_graph(tree(parents, order))
    n = len(parents)
    P = np.zeros((n, n), int)
    for i, link in enumerate(graph.links):
        assert link.parent < i, "parents come before their children"
        if link.parent >= 0:
            P[i, link.parent] = 1
        number = int(link.body.name[1:])
        assert link.joint.name == f"j{number}"
        assert (link.parent < 0) == (parents[number] < 0)
        assert link.parent < 0 or graph.links[link.parent].body.name == f"b{parents[number]}"
    assert (graph.T @ (np.eye(n, dtype=int) - P) == np.eye(n)).all(), "T = (I - P)^-1"
    rows = np.linalg.inv(graph.T).T.round().astype(int)  # exact: entries are 0, 1 and -1
    for i in range(n):
        want = {i: 1} | dict.fromkeys(children_of(graph.T, i), -1)
        assert {j: x for j, x in enumerate(rows[i]) if x} == want
    for span in graph.trees():
        assert [graph.links[i].parent < 0 for i in span] == [True] + [False] * (len(span) - 1)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(trees)
def test_bodies_listed_with_each_parent_before_its_children_keep_their_numbers_in_the_path_matrix(parents):
    graph = build_graph(tree(parents, range(len(parents))))
    names = {link.body.name: i for i, link in enumerate(graph.links)}
    T = path_matrix(list(parents))
    for k in range(len(parents)):
        for i in range(len(parents)):
            assert graph.T[names[f"b{k}"], names[f"b{i}"]] == T[k, i]


def test_equations_1_to_4_of_the_paper_are_printed_for_the_four_link_arm():
    text = equations(tree(ARM, range(4)))
    assert text.startswith(
        "GRAPH\n   body  joint  kind      on\n"
        "1  b0    j0     revolute  world\n2  b1    j1     revolute  b0\n"
        "3  b2    j2     revolute  b0\n4  b3    j3     revolute  b2\n\nPATH MATRIX"
    )
    for row in ("1 0 0 0", "1 1 0 0", "1 0 1 0", "1 0 1 1"):
        assert f"\n  {row}\n" in text
    for row in ('m1 r1" = F1 + Fc1 - Fc2 - Fc3', 'm2 r2" = F2 + Fc2', 'm3 r3" = F3 + Fc3 - Fc4', 'm4 r4" = F4 + Fc4'):
        assert f" {row}\n" in text
    assert "nan" not in text


def test_printing_equations_twice_gives_the_same_text():
    assert equations(tree(ARM, range(4))) == equations(tree(ARM, range(4)))


def test_a_chain_of_bodies_may_be_longer_than_the_recursion_limit():
    n = 2000
    graph = build_graph(tree(range(-1, n - 1), range(n)[::-1]))
    assert [k.parent for k in graph.links] == list(range(-1, n - 1))
    assert graph.T.sum() == n * (n + 1) // 2
