"""Modules of earlier versions under their old names, for users' files: imported with a warning.

Removed one minor version after the warning first appeared.
"""

import importlib
import importlib.machinery
import sys
import warnings

LAWS = "control.laws"  # a package
# Old name: new name, both within the package.
MOVED = {
    LAWS: "protocols",
    "control.laws.carrying": "protocols.carrying.law",
    "control.laws.common": "protocols.common",
    "control.laws.consensus": "protocols.consensus.law",
    "control.laws.consensus_equations": "protocols.consensus.equations",
    "control.laws.consensus_memory": "protocols.consensus.memory",
    "control.laws.currents": "protocols.currents.law",
    "control.laws.energies": "protocols.energies",
    "control.laws.event_triggered_consensus": "protocols.consensus.event_triggered",
    "control.laws.exploration": "protocols.exploration.law",
    "control.laws.flocking": "protocols.flocking.law",
    "control.laws.flocking_equations": "protocols.flocking.equations",
    "control.laws.formation": "protocols.formation.law",
    "control.laws.formation_equations": "protocols.formation.equations",
    "control.laws.formations": "protocols.shapes.law",
    "control.laws.formations_equations": "protocols.shapes.equations",
    "control.laws.gathering": "protocols.gathering.law",
    "control.laws.gathering_equations": "protocols.gathering.equations",
    "control.laws.marching": "protocols.marching.law",
    "control.laws.marching_equations": "protocols.marching.equations",
    "control.laws.noisy_consensus": "protocols.consensus.noisy",
    "control.laws.platoon": "protocols.marching.platoon",
    "control.laws.published": "protocols.published.laws",
    "control.laws.published_consensus": "protocols.consensus.published",
    "control.laws.published_currents": "protocols.currents.published",
    "control.laws.published_flocking": "protocols.flocking.published",
    "control.laws.published_formations": "protocols.shapes.published",
    "control.laws.resilient_consensus": "protocols.consensus.resilient",
    "control.laws.sensing": "protocols.sensing.law",
    "control.laws.switching_consensus": "protocols.consensus.switching",
    "control.laws.trajectory": "protocols.trajectory.law",
    "control.loading": "protocols.loading",
    "control.making": "protocols.making",
    "core.curves": "protocols.curves",
    "core.layouts": "scenario.team.layouts",
    "core.links": "scenario.network.links",
    "core.maps": "scenario.surroundings.maps",
    "core.moving": "scenario.surroundings.moving_obstacles",
    "core.obstacles": "scenario.surroundings.obstacles",
    "core.parameters": "core.fields",
    "core.reading": "scenario.reading",
    "core.recording": "record.recording",
    "core.scenario": "scenario.scenario",
    "core.verdict": "verdict.verdict",
    "study.animation": "study.draw.animation",
    "study.bag": "study.results.bag_reading",
    "study.check_protocol": "study.check.check_protocol",
    "study.compare": "study.results.compare",
    "study.experiment": "study.run.experiment",
    "study.export": "study.results.export",
    "study.figures": "study.draw.figures",
    "study.film": "study.draw.space_film",
    "study.report": "study.results.report",
    "study.shipped": "scenario.shipped",
    "study.simulating": "study.run.simulating",
    "study.sweep": "study.run.sweep",
    "study.view": "study.draw.view",
}
# Names that such a module no longer has: where they are.
SPLIT = {
    "control.laws.energies": {
        "protocols.consensus.energies": ("second_order_energy",),
        "protocols.flocking.energies": ("flock_energy", "agreement_energy"),
        "protocols.gathering.energies": ("tension_energy", "coverage_energy"),
        "protocols.shapes.energies": ("length_energy", "bearing_energy"),
    },
    "control.laws.published_consensus": {
        "protocols.gathering.published": ("Pursuit", "Rendezvous", "Coverage"),
        "protocols.marching.published": ("Chain",),
    },
}
PACKAGE = __name__.rpartition(".")[0] + "."


class OldNames:
    """Finder and loader of the modules in ``MOVED``: an old name gives the new module itself."""

    def find_spec(self, name, path=None, target=None):
        """Return the specification of an old name; None of any other, which is left to others."""
        if not name.startswith(PACKAGE) or name[len(PACKAGE) :] not in MOVED:
            return None
        return importlib.machinery.ModuleSpec(name, self, is_package=name == PACKAGE + LAWS)

    def create_module(self, spec):
        """Return the module that has moved, with a ``FutureWarning`` at the line that imports it."""
        if spec.submodule_search_locations is not None:
            return None  # a package of its own: its modules become attributes of it
        new = PACKAGE + MOVED[spec.name[len(PACKAGE) :]]
        text = "{} is now {}; the old name will go with the next minor version"
        warnings.warn(text.format(spec.name, new), FutureWarning, stacklevel=2)
        module = importlib.import_module(new)
        for home, names in SPLIT.get(spec.name[len(PACKAGE) :], {}).items():
            for name in names:
                setattr(module, name, getattr(importlib.import_module(PACKAGE + home), name))
        self._spec = module.__spec__  # importlib puts the old name's in its place
        return module

    def exec_module(self, module):
        """Run nothing: the module was run under its new name."""
        if module.__name__ == PACKAGE + LAWS:
            new = importlib.import_module(PACKAGE + MOVED[LAWS])
            module.__getattr__ = lambda name: getattr(new, name)
        else:
            module.__spec__ = self._spec


def install():
    """Let old names be imported, before a package's new place finds another module of the same name."""
    sys.meta_path.insert(0, OldNames())
