"""Kind files and descriptions with anything in them: a valid robot or a clear error, never a traceback."""

import copy
import math
import os
import xml.etree.ElementTree as ElementTree

import numpy as np
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from robot_descriptions import CONTROLLER, urdf, write_package
from test_fuzz import VALUES, places, put

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.vehicles import kind
from mrs_simulator.vehicles.registry import DIRECTORY

FEW = settings(
    max_examples=50,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
WORDS = st.one_of(
    st.sampled_from(["", "nan", "inf", "-1", "0", "1e308", "1 2", "0 0 0", "base_link", "fixed"]),
    st.text(alphabet=st.characters(min_codepoint=32, max_codepoint=0x2FF), max_size=6),
)
CONTROLLERS = yaml.safe_load(CONTROLLER)
with open(os.path.join(DIRECTORY, "pioneer3dx.yaml")) as PIONEER:
    KIND = yaml.safe_load(PIONEER)
ELEMENTS = len(list(ElementTree.fromstring(urdf()).iter()))


def changed(content, place, value):
    """Return ``content`` with another ``value`` at ``place``."""
    result = copy.deepcopy(content)
    put(result, place, value)
    return result


def check(load):
    """``load`` must return a robot that can be, or say what is wrong in one line."""
    try:
        found = load()
    except ScenarioError as error:
        assert str(error) and "\n" not in str(error) and len(str(error)) < 2000
        return False
    body, wheels = found.body, found.numbers
    sizes = [found.mass, body.length, body.width, body.height, wheels.track, wheels.radius]
    assert all(math.isfinite(size) and size > 0.0 for size in sizes)
    assert body.front >= 0.0 and body.rear >= 0.0
    assert all(limit.top > 0.0 for limit in found.limits["firmware"])
    if found.model:
        numbers = [
            float(text)
            for element in ElementTree.parse(found.model).iter()
            for name in ("xyz", "rpy", "value", "size", "radius", "length", "ixx", "iyy", "izz")
            for text in element.get(name, "").split()
        ]
        assert np.isfinite(numbers).all()
    return True


@FEW
@given(
    st.integers(0, ELEMENTS - 1),
    st.sampled_from(["value", "text", "gone", "twice", "renamed", "moved"]),
    WORDS,
    st.integers(0, 5),
    st.integers(0, ELEMENTS - 1),
)
def test_any_change_of_a_description(tmp_path, index, change, word, which, other):
    root = ElementTree.fromstring(urdf())
    elements = list(root.iter())
    element, parents = elements[index], {child: each for each in elements for child in each}
    parent = parents.get(element, root)
    if change == "value" and element.attrib:
        element.set(sorted(element.attrib)[which % len(element.attrib)], word)
    elif change == "text":
        element.text = word
    elif change == "renamed":
        element.tag = elements[other].tag
    elif element is not root:
        if change != "twice":
            parent.remove(element)
        if change == "twice":
            parent.append(copy.deepcopy(element))
        elif change == "moved" and elements[other] not in set(element.iter()):
            elements[other].append(element)
    text = ElementTree.tostring(root, encoding="unicode")
    path = write_package(tmp_path, text)
    check(lambda: kind(path))


@FEW
@given(st.binary(max_size=40), st.integers(0, len(urdf())), st.integers(0, 60))
def test_any_bytes_in_a_description(tmp_path, new, start, length):
    path = write_package(tmp_path)
    content = urdf().encode()
    with open(path, "wb") as file:
        file.write(content[:start] + new + content[start + length :])
    check(lambda: kind(path))


@FEW
@given(st.data(), VALUES)
def test_any_value_in_a_controllers_file(tmp_path, data, value):
    place = data.draw(st.sampled_from(sorted(places(CONTROLLERS), key=str)))
    path = write_package(tmp_path, urdf(plugin=""))
    directory = os.path.dirname(path)
    with open(os.path.join(directory, "control.yaml"), "w") as file:
        yaml.safe_dump(changed(CONTROLLERS, place, value), file)
    own = {"scout": {"import": {"urdf": path, "controller": "control.yaml"}}}
    check(lambda: kind("scout", directory, own))


@FEW
@given(st.data(), VALUES)
def test_any_value_in_a_kinds_file(tmp_path, data, value):
    content = {key: part for key, part in KIND.items() if key != "model"}
    content["import"] = {"urdf": write_package(tmp_path), "packages": {}, "arguments": {}}
    if data.draw(st.booleans()):
        content = {"base": "pioneer3dx", "limits": content["limits"], "body": content["body"]}
    place = data.draw(st.sampled_from(sorted(places(content), key=str)))
    with open(str(tmp_path / "mine.yaml"), "w") as file:
        yaml.safe_dump(changed(content, place, value), file)
    check(lambda: kind(str(tmp_path / "mine.yaml")))


def test_the_robots_that_are_changed_are_valid(tmp_path):
    path = write_package(tmp_path)
    assert check(lambda: kind(path))
    own = {"scout": {"import": {"urdf": path, "controller": "control.yaml"}}}
    assert check(lambda: kind("scout", os.path.dirname(path), own))
