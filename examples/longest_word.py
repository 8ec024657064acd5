"""A word policy of one's own: the longest waiting word first.

python3 scripts/run_headless.py --word-policy examples/longest_word.py:LongestWord
"""

from __future__ import annotations

from soup_managers.policies import WordPolicy
from soup_msgs_py.messages import AssignWord


class LongestWord(WordPolicy):
    """Opens the longest waiting word on the word station with the fewest open words."""

    def choose(self, view, stations, rng):
        """One word and one station; see `WordPolicy.choose`."""
        longest = max(view.waiting_words.values(), key=lambda word: len(word.tiles))
        station = max(stations, key=view.free_places.__getitem__)
        return AssignWord(longest.word, station)
