"""What a robot is: drives are modules, kinds are data, a team is the robots of a run."""

from mrs_simulator.vehicles.kind import Kind
from mrs_simulator.vehicles.registry import kind, shipped_kinds
from mrs_simulator.vehicles.team import Team

__all__ = ["KINDS", "Kind", "Team", "kind", "robot_kind", "shipped_kinds"]

KINDS = shipped_kinds()
robot_kind = kind
