"""The shipped protocols: a name for each, and the class behind it."""

import importlib

# Scenarios, launch files and the GUI name them so.
HOMES = {
    "bearing_formation": "formations:BearingFormation",
    "bearing_leaders": "formations:BearingLeaders",
    "carrying": "carrying:Carrying",
    "consensus": "consensus:Consensus",
    "containment": "gathering:Containment",
    "coverage": "gathering:Coverage",
    "cucker_smale": "flocking:CuckerSmale",
    "cyclic_pursuit": "gathering:CyclicPursuit",
    "delayed_consensus": "consensus_memory:DelayedConsensus",
    "discrete_consensus": "consensus:DiscreteConsensus",
    "displacement_formation": "formations:DisplacementFormation",
    "distance_formation": "formations:DistanceFormation",
    "event_triggered_consensus": "event_triggered_consensus:EventTriggeredConsensus",
    "exploration": "exploration:Exploration",
    "flocking": "flocking:Flocking",
    "formation": "formation:Formation",
    "leader_follower": "marching:LeaderFollower",
    "limited_visibility": "sensing:LimitedVisibility",
    "line_of_sight": "currents:LineOfSight",
    "marching": "marching:Marching",
    "noisy_consensus": "noisy_consensus:NoisyConsensus",
    "platoon": "platoon:Platoon",
    "rendezvous": "gathering:Rendezvous",
    "resilient_consensus": "resilient_consensus:ResilientConsensus",
    "reynolds": "flocking:Reynolds",
    "second_order_consensus": "consensus_memory:SecondOrderConsensus",
    "sensed_following": "sensing:SensedFollowing",
    "station_keeping": "currents:StationKeeping",
    "switching_consensus": "switching_consensus:SwitchingConsensus",
    "trajectory": "trajectory:Trajectory",
    "vicsek": "flocking:Vicsek",
    "wall_following": "sensing:WallFollowing",
}


def shipped(name):
    """Return the class of the shipped protocol called ``name``; ``KeyError`` if there is none."""
    module, _, class_name = HOMES[name].partition(":")
    return getattr(importlib.import_module("mrs_simulator.control.laws." + module), class_name)
