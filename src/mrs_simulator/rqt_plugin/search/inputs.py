"""What a search of the GUI is given: what may vary, and how much; without Qt."""

import difflib
import math

import yaml

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError, parse_yaml
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.search import NO_SEARCH, POSES, ROBOTS, search_from
from mrs_simulator.study.run.sweep import put_key
from mrs_simulator.study.search.default_space import apart_of, box_of
from mrs_simulator.study.search.space import Space

DIGITS = 3  # of a box that is suggested
WHERE = "what may vary"
PARAMETERS = "control.parameters."  # where the law's are


def suggested(scenario):
    """Return what may vary of a scenario, as its key ``search`` has it, a line for each key.

    Where it says nothing robots may begin anywhere about where they do.
    """
    plain = scenario.search.to_plain()
    if not plain:
        box = [round(each, DIGITS) for each in box_of(scenario.poses)]
        plain = {POSES: {"within": box, "apart": apart_of(scenario)}}
    elif POSES in plain and plain[POSES]["headings"] == [-math.pi, math.pi]:
        del plain[POSES]["headings"]  # anywhere, as if nothing was said
    return "".join(_line(key, value) for key, value in plain.items())


def _line(key, value):
    flow = yaml.safe_dump(_whole(value), default_flow_style=True, sort_keys=False, width=math.inf)
    return "{}: {}\n".format(key, flow.strip())


def _whole(value):
    """Return ``value`` with whole numbers in place of those that are whole."""
    if isinstance(value, dict):
        return {key: _whole(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_whole(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def with_search(scenario, text, parameters=()):
    """Return the ``scenario`` whose key ``search`` is the ``text``; ``ScenarioError`` where it is none.

    ``parameters``: names of the law's, which may stand for the paths of their keys.
    """
    given = parse_yaml(text, WHERE)
    if not isinstance(given, dict):
        raise ScenarioError("{}: wanted lines such as mismatch.delay: [0, 0.4]".format(WHERE))
    paths = {name: PARAMETERS + name for name in parameters}
    search = search_from({paths.get(key, key): value for key, value in given.items()}, WHERE)
    Space(search, scenario.n, scenario.topology)  # is not empty
    for each in search.ranges:
        if each.key != ROBOTS:
            _refuse_unknown(scenario, each, parameters)
    return scenario._replace(search=search)


def _refuse_unknown(scenario, varied, parameters):
    """Raise ``ScenarioError`` where the key of a ``Range`` is none of the scenario, nor its end a value."""
    content = scenario.to_dict()
    own = "." not in varied.key and varied.key not in content
    if own and difflib.get_close_matches(varied.key, parameters, n=1):
        raise ScenarioError(unknown_name(WHERE, varied.key, parameters))
    name = varied.key[len(PARAMETERS) :]
    if parameters and varied.key.startswith(PARAMETERS) and name not in parameters:
        raise ScenarioError(unknown_name(WHERE + "." + PARAMETERS[:-1], name, parameters))
    value = int(varied.low) if varied.whole else varied.low
    put_key(content, varied.key, varied.choices[0] if varied.choices else value)
    scenario_from_dict(content, WHERE)


def without_search(scenario):
    """Return the ``scenario`` in which nothing is said to vary."""
    return scenario._replace(search=NO_SEARCH)


def read_share(text):
    """Return the number in ``text``, a share between 0 and 1; ``ValueError`` says what is wrong."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        raise ValueError("{!r}: wanted a number between 0 and 1".format(text))
    return value
