"""Valid and invalid force laws as a user writes them."""

import math
import random

import numpy as np
from heavylift.kernel.forces.mathematics import cos, maximum, select, sin, sqrt


def van_der_pol(x):
    mu, omega = x.parameters
    return mu * (1 - x.q**2) * x.dq - omega**2 * x.q


def shaker(x):
    return x.signal * sin(3.0 * x.t + 0.5)


def magnus(x):
    """Lift of a spinning body in still air and a moment that slows its spin."""
    (c, d) = x.parameters
    w, v = x.w[0], x.v[0]
    lift = np.array([w[1] * v[2] - w[2] * v[1], w[2] * v[0] - w[0] * v[2], w[0] * v[1] - w[1] * v[0]])
    return [[*(c * lift), *(-d * w * sqrt(w @ w + 1e-30))]]


def tether(x):
    """Pulls the second end towards the first beyond a metre."""
    s = x.p[1] - x.p[0]
    length = sqrt(s @ s)
    pull = 40.0 * maximum(length - 1.0, 0.0) / length * s
    return [pull, -pull]


def relay(x):
    return select(x.modes[0] > 0.0, -2.0, 2.0)


def beyond_the_middle(x):
    return [x.q - 0.1 * cos(0.0)]


def branching(x):
    if x.q > 0.0:
        return 1.0
    return -1.0


def by_the_library(x):
    return math.sin(x.q)


def by_numpy(x):
    return np.sin(x.q)


def looping(x):
    force = 0.0
    while force < x.q:
        force += 1.0
    return force


def too_many(x):
    return [1.0, 2.0]


def a_word(x):
    return "strong"


def nothing(x):
    return None


def misspelt(x):
    return x.position


def counting(x):
    return (x.q > 0.0) * 3.0


def answering(x):
    return x.q > 0.0


def choosing(x):
    return select(x.q, 1.0, 2.0)


def by_a_root(x):
    return x.q**0.5


def gambling(x):
    return random.random()


def undefined(x):
    return math.nan
