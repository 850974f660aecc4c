"""The shipped protocols: a name for each, and the class behind it."""

import importlib

# Scenarios, launch files and the GUI name them so.
HOMES = {
    "bearing_formation": "shapes.law:BearingFormation",
    "bearing_leaders": "shapes.law:BearingLeaders",
    "carrying": "carrying.law:Carrying",
    "consensus": "consensus.law:Consensus",
    "containment": "gathering.law:Containment",
    "coverage": "gathering.law:Coverage",
    "cucker_smale": "flocking.law:CuckerSmale",
    "cyclic_pursuit": "gathering.law:CyclicPursuit",
    "delayed_consensus": "consensus.memory:DelayedConsensus",
    "discrete_consensus": "consensus.law:DiscreteConsensus",
    "displacement_formation": "shapes.law:DisplacementFormation",
    "distance_formation": "shapes.law:DistanceFormation",
    "event_triggered_consensus": "consensus.event_triggered:EventTriggeredConsensus",
    "exploration": "exploration.law:Exploration",
    "flocking": "flocking.law:Flocking",
    "formation": "formation.law:Formation",
    "leader_follower": "marching.law:LeaderFollower",
    "limited_visibility": "sensing.law:LimitedVisibility",
    "line_of_sight": "currents.law:LineOfSight",
    "marching": "marching.law:Marching",
    "noisy_consensus": "consensus.noisy:NoisyConsensus",
    "platoon": "marching.platoon:Platoon",
    "rendezvous": "gathering.law:Rendezvous",
    "resilient_consensus": "consensus.resilient:ResilientConsensus",
    "reynolds": "flocking.law:Reynolds",
    "second_order_consensus": "consensus.memory:SecondOrderConsensus",
    "sensed_following": "sensing.law:SensedFollowing",
    "station_keeping": "currents.law:StationKeeping",
    "switching_consensus": "consensus.switching:SwitchingConsensus",
    "trajectory": "trajectory.law:Trajectory",
    "vicsek": "flocking.law:Vicsek",
    "wall_following": "sensing.law:WallFollowing",
}


def shipped(name):
    """Return the class of the shipped protocol called ``name``; ``KeyError`` if there is none."""
    module, _, class_name = HOMES[name].partition(":")
    return getattr(importlib.import_module("mrs_simulator.protocols." + module), class_name)
