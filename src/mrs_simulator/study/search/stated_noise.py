"""The noise that a scenario states of sensors and odometry, made larger: an axis of margins."""

import copy

from mrs_simulator.vehicles.quantities import times

NOISE = "noise"  # the key of a variation
SCALED = ("stddev", "bias_walk", "walk")  # what is so many times as large; `alpha` are variances


def states_noise(content):
    """Return whether the scenario's ``content`` states noise."""
    changed = copy.deepcopy(content)
    enlarge_noise(changed, 2.0)
    return changed != content


def enlarge_noise(content, factor):
    """Let all standard deviations of noise in a scenario's ``content`` be ``factor`` times as large.

    Those of `odometry_errors`, and of mounts under `sensors` and `kinds`, each as it is written there.
    """
    done = set()  # of what YAML's anchors hold several times
    _enlarge(content.get("odometry_errors"), factor, done)
    for noise in _noise_in([content.get("sensors"), content.get("kinds")]):
        _enlarge(noise, factor, done)


def _noise_in(found):
    """Yield what is under keys `noise` in lists and mappings."""
    if isinstance(found, dict):
        for key, value in found.items():
            yield from [value] if key == NOISE else _noise_in(value)
    elif isinstance(found, list):
        for value in found:
            yield from _noise_in(value)


def _enlarge(noise, factor, done):
    if not isinstance(noise, dict) or id(noise) in done:
        return
    done.add(id(noise))
    for key, value in noise.items():
        if isinstance(value, dict):
            _enlarge(value, factor, done)
        elif key in SCALED:
            noise[key] = times(factor, value)
        elif key == "alpha" and isinstance(value, list):
            noise[key] = [times(factor**2, each) for each in value]
