"""The rules of leader election: who is in charge of a role where several could be. They know no clock.

The first is, and when it goes the next.
"""

from __future__ import annotations

from enum import Enum

from soup_msgs_py.messages import Charge

LOOK_S = 2.5  # wall time in which a newcomer hears of whoever is in charge, on a busy machine, too
ALONE_S = 6.0  # wall time after which it looks no longer for anybody
SETTLE_S = 0.5  # wall time in which two who take over at once hear of each other


class Standing(Enum):
    """How a candidate stands to its role."""

    LOOKS = "looks"
    STANDS_BY = "stands by"
    CLAIMS = "claims"
    IN_CHARGE = "in charge"
    REPLACED = "replaced"


class Election:
    """One candidate for a role.

    It looks around first; where somebody is in charge it stands by until that one is gone. Of two that take over
    at the same moment the stronger claim stays. One that was thought gone (it was stopped, or cut off) and comes
    back finds a claim of a later term: it is replaced, and is to end.

    Attributes:
        standing: How it stands now.
        other: The newest claim of somebody else.
        claim: Its own, once it claims.
    """

    def __init__(self, part: str, rank: int, policy: str, wall: float) -> None:
        """Begin to look.

        Args:
            part: Name of the process.
            rank: Any number that the others do not have.
            policy: What it follows.
            wall: Wall time now (s).
        """
        self.standing = Standing.LOOKS
        self.other: Charge | None = None
        self.claim = Charge(part, 0, rank, policy)
        self._began = self._since = wall
        self._others = 0

    def alive(self, others: int) -> None:
        """So many others are in charge, or claim to be."""
        self._others = others

    def heard(self, claim: Charge) -> None:
        """Somebody claims to be in charge."""
        if claim.rank == self.claim.rank:
            return
        if self.other is None or _stronger(claim, self.other):
            self.other = claim
        if self.standing in (Standing.CLAIMS, Standing.IN_CHARGE) and _stronger(claim, self.claim):
            settled = self.standing is Standing.IN_CHARGE
            self.standing = Standing.REPLACED if settled else Standing.STANDS_BY

    def look(self, wall: float, *, alone: bool = False) -> bool:
        """Go on as time goes by.

        Args:
            wall: Wall time now (s).
            alone: Whether it has met nobody yet, on a machine that is too busy for that maybe.

        Returns:
            Whether it claims now: its claim is to be told, and to be alive, from now on.
        """
        if alone and self.standing is Standing.LOOKS and wall - self._began < ALONE_S:
            self._since = wall
        if self.standing is Standing.LOOKS and wall - self._since >= LOOK_S:
            self.standing = Standing.STANDS_BY
        if self.standing is Standing.STANDS_BY and self._others <= 0:
            self.standing, self._since = Standing.CLAIMS, wall
            term = self.other.term if self.other is not None else 0
            self.claim = Charge(self.claim.part, term + 1, self.claim.rank, self.claim.policy)
            return True
        if self.standing is Standing.CLAIMS and wall - self._since >= SETTLE_S:
            self.standing = Standing.IN_CHARGE
        return False


def _stronger(one: Charge, other: Charge) -> bool:
    return (one.term, -one.rank) > (other.term, -other.rank)
