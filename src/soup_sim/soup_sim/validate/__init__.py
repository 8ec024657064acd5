"""An independent judge of a run: it rebuilds the warehouse from events alone and names every broken law.

It shares nothing with the engine. `Judge` follows a run as it goes, `judge_log` judges one that is over.
"""

from soup_sim.validate.judge import Judge, judge_log
from soup_sim.validate.violations import EPSILON, Law, Violation

__all__ = ["EPSILON", "Judge", "Law", "Violation", "judge_log"]
