"""Stations in a ring that pass on tokens: a cycle of atomic models, each of which holds a token for some time."""

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out


class Token(Message):
    """A token with its number."""

    number: int


class RingStation(Atomic):
    """Station of a token ring: holds tokens for `hold` [ns], then passes them on.

    `first`: the token that the station holds at the start."""

    into, out = In(Token), Out(Token)

    def __init__(self, name: str, hold: int, first: Token | None = None) -> None:
        super().__init__(name)
        self.hold, self.first = hold, first

    def start(self) -> None:
        """Start the station with the token `first`, if there is one."""
        self.tokens = (self.first,) if self.first else ()
        self.passed = 0
        if self.tokens:
            self.hold_in(self.hold)

    def external(self, e: int, x: Bag) -> None:
        """Add the received tokens to those that the station holds; all of them are then passed on together."""
        self.tokens = (*self.tokens, *x[self.into])
        self.hold_in(self.hold)

    def output(self) -> None:
        """Send all tokens that the station holds."""
        for token in self.tokens:
            self.out.send(token)

    def internal(self) -> None:
        """Remove the tokens that the station has passed on."""
        self.passed += len(self.tokens)
        self.tokens = ()
        self.passivate()


def ring(stations: int, tokens: int, hold: int) -> Coupled:
    """Return a ring of stations, of which the first `tokens` stations hold a token at the start; `hold` is in ns."""
    model = Coupled("ring")
    members = [model.add(RingStation(f"s{i}", hold, Token(i) if i < tokens else None)) for i in range(stations)]
    for i, member in enumerate(members):
        model.connect(member.out, members[(i + 1) % stations].into)
    return model
