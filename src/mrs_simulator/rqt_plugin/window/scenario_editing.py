"""The edited scenario: shown in the panels, and changed by edits there."""

import numpy as np

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.window.obstacle_editing import ObstacleEditing
from mrs_simulator.scenario.surroundings.maps import obstacles_of


@guarded
class ScenarioEditing:
    """Shows the study's scenario, and applies the user's edits of team, protocol and graph."""

    def __init__(self, panels, study, live, pending_team, pending_graph):
        """``live``: the ``LiveRun``, which is cleared as soon as the team changes."""
        self._panels, self._study, self._live = panels, study, live
        self._team, self._graph = pending_team, pending_graph
        self.obstacles = ObstacleEditing(panels, study, self._on_obstacles)
        panels.team.team_changed.connect(self._on_team)
        panels.team.arranged.connect(guarded(lambda *_: panels.map.fit()))
        panels.protocol.protocol_chosen.connect(self._on_protocol)
        panels.protocol.parameters_changed.connect(self._on_parameters)
        panels.protocol.safety_changed.connect(self._on_safety)
        panels.topology.topology_changed.connect(self._on_topology)
        panels.bar.duration.chosen.connect(self._on_duration)
        panels.bar.duration.refused.connect(guarded(lambda why: panels.say(ErrorMessage(why))))
        panels.map.pose_edited.connect(self._on_pose)
        panels.map.poses_edited.connect(self._on_poses)
        panels.map.edge_added.connect(guarded(panels.topology.add_edge))
        panels.map.edge_removed.connect(guarded(panels.topology.remove_edge))
        for asked in (panels.map.undo_asked, panels.bar.undo_asked):
            asked.connect(self._on_undo)
        for asked in (panels.map.redo_asked, panels.bar.redo_asked):
            asked.connect(self._on_redo)

    # Showing -------------------------------------------------------------------------------------

    def take(self, scenario):
        """Open ``scenario``: team, protocol, parameters, topology, obstacles.

        Whatever its protocol and its map raise is raised, and the old scenario stays.
        """
        obstacles_of(scenario)  # reads the map's file
        self._study.edited.take(scenario)
        self.show()

    def show(self):
        """Show the scenario in force."""
        scenario = self._study.scenario
        self._show_team()
        self.obstacles.begin()
        self._panels.bar.set_speed(scenario.speed)
        self._show_protocol()
        self._panels.map.fit(whole=True)  # with its own targets, not the previous ones

    def show_on_map(self):
        """Show the scenario in force on the map, where another run was shown."""
        scenario = self._study.scenario
        derived = self._study.edited.derived
        shown = self._panels.map
        shown.show_team(scenario.poses, scenario.altitude)
        self._show_kinds()
        self.obstacles.show()
        shown.show_topology(derived.topology.edges, derived.topology.directed)
        shown.show_targets(derived.targets)
        shown.fit(whole=True)

    def _show_team(self):
        """Show the team in force."""
        scenario = self._study.scenario
        self._panels.team.set_kinds(self._study.edited.kind, scenario.own_kinds)
        self._panels.team.set_team(scenario.poses, scenario.kinds, scenario.altitude)
        self._panels.map.show_team(scenario.poses, scenario.altitude)
        self._show_kinds()

    def _show_kinds(self):
        team = self._study.edited.team()
        self._panels.map.show_kinds(team.kinds)
        self._panels.map.show_load(self._study.scenario.load)
        self._panels.curves.set_axes(team.axes, team.is_spatial)

    def _show_protocol(self):
        """Show the protocol in force, its parameters and its graph."""
        derived, protocol = self._study.edited.derived, self._panels.protocol
        protocol.set_protocol(self._study.scenario.control.protocol)
        protocol.set_parameters(derived.parameters, derived.values)
        protocol.safety.setChecked(bool(self._study.scenario.control.safety))
        self._show_derived()

    def _show_derived(self):
        """Show what follows from the scenario in force: warnings, graph and targets."""
        panels = self._panels
        connection = self._study.connection
        derived = self._study.edited.derived
        panels.close_error()  # an edit was applied
        edited = self._study.edited
        connection.set_starts(edited.starts(), edited.team().is_spatial)
        panels.protocol.set_warnings(derived.warnings)
        edges, directed = derived.topology.edges, derived.topology.directed
        panels.topology.set_team(self._study.scenario.poses[:, :2])
        panels.topology.set_convergence_time("...")
        panels.topology.set_topology(edges, directed)
        panels.map.show_topology(edges, directed)
        if not connection.is_fresh("control"):  # which publishes its targets
            panels.map.show_targets(None if connection.is_fresh("state") else derived.targets)
        self._live.show_theory()

    # Team ----------------------------------------------------------------------------------------

    def _on_team(self):
        self._change_team()
        scenario = self._study.scenario
        self._panels.map.show_team(scenario.poses, scenario.altitude)
        self._show_kinds()

    def _on_pose(self, number, x, y, theta):
        self._panels.team.set_pose(number, x, y, theta)
        self._change_team()

    def _on_poses(self, poses):
        self._panels.team.set_poses(poses)
        self._change_team()

    def _change_team(self):
        team = self._panels.team
        edited = team.poses(), team.kinds(), team.altitude()
        if self._panels.say(self._study.edited.set_team(*edited)):
            self._show_team()
            return
        self._team.changed()
        self._live.put_away()
        self._show_derived()

    def _on_obstacles(self):
        self._live.put_away()
        self._show_derived()

    # Undo ----------------------------------------------------------------------------------------

    def _on_undo(self):
        undo = self._study.edited.undo
        self._exchange(undo.done, undo.undone)

    def _on_redo(self):
        undo = self._study.edited.undo
        self._exchange(undo.undone, undo.done)

    def _exchange(self, source, target):
        """Apply the last scenario of ``source``; the one in force goes to ``target``."""
        study = self._study
        if not source:
            return
        before, after = study.scenario, source[-1]
        wrong = self._locked(before, after)
        wrong = ErrorMessage("not undone: " + wrong) if wrong else study.edited.restore(after)
        if self._panels.say(wrong):
            return
        study.edited.undo.exchange(source, target, before)
        self._show_restored(before, after)

    def _locked(self, before, after):
        """Return why the edit from ``before`` to ``after`` cannot be made now, or ""."""
        state, team = self._study.state, before.n != after.n or before.kinds != after.kinds
        moved = team or not _same_places(before, after)
        return (
            (team and state.team_locked())
            or (moved and state.poses_locked(after.n))
            or (before.obstacles != after.obstacles and state.obstacles_locked())
            or ""
        )

    def _show_restored(self, before, after):
        panels, control = self._panels, self._study.control
        if before.control.protocol != after.control.protocol:
            panels.say(control.follow_protocol())
        elif before.obstacles != after.obstacles:
            panels.say(control.follow_obstacles())
        self._show_team()
        self.obstacles.show()
        self._show_protocol()
        if before.n != after.n or before.kinds != after.kinds or not _same_places(before, after):
            self._team.changed()
            self._live.put_away()
        elif before.obstacles != after.obstacles:
            self._live.put_away()

    # Protocol, graph and duration ----------------------------------------------------------------

    def _on_protocol(self, name):
        if self._panels.say(self._study.edited.set_protocol(name)):
            self._panels.protocol.set_protocol(self._study.scenario.control.protocol)
            return
        self._panels.say(self._study.control.follow_protocol())
        self._show_protocol()

    def _on_parameters(self, values):
        if self._panels.say(self._study.edited.set_parameters(values)):
            self._show_protocol()
        else:
            self._show_derived()

    def _on_safety(self, on):
        wrong = self._panels.say(self._study.edited.set_safety(on))
        if not wrong and self._study.state.has_control():
            self._panels.say(
                "the safety filter is {} from the next start on".format("on" if on else "off")
            )
        self._show_protocol()

    def _on_topology(self, edges, directed):
        refused = self._panels.say(self._study.edited.set_topology(edges, directed))
        if not refused and self._study.state.has_control():
            self._graph.asked(edges, directed)
        self._show_protocol()

    def _on_duration(self, duration):
        wrong = self._study.edited.set_duration(duration)
        if wrong:
            self._panels.bar.duration.refuse(wrong)
        else:
            self._panels.bar.show_duration(self._study.scenario.duration)
            self._show_derived()


def _same_places(before, after):
    """Return whether two scenarios of as many robots put them to the same poses and heights."""
    heights = (np.zeros(1) if each.altitude is None else each.altitude for each in (before, after))
    return np.array_equal(before.poses, after.poses) and np.array_equal(*heights)
