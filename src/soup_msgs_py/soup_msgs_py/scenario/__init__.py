"""A run's world as a person describes it: the scenario file, its model and its checks."""

from soup_msgs_py.scenario.scenario import Scenario as Scenario
from soup_msgs_py.scenario.scenario import load_scenario as load_scenario
from soup_msgs_py.scenario.scenario import load_words as load_words
from soup_msgs_py.scenario.scenario import scenario_from_json as scenario_from_json
