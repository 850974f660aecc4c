"""Shows the state of master, stage, controller and robots, and banners on what needs attention."""

import html

GOOD = {True: "#2e8b57", False: "#c00000", None: "#888888"}  # colour of a light
LATCHED = (
    "EMERGENCY STOP: no controller moves any robot. Press RELEASE STOP to release it, and then "
    "Start controller to go on, or Run."
)
MASTER_LOST = (
    "The ROS master does not answer. Programs that run go on, and EMERGENCY STOP reaches controllers that "
    "were connected; nothing can be started, reset or paused until roscore runs again."
)
UNTIMELY = (
    "{}. This run gets no verdict: choose a slower speed in the box beside End, and press Run."
)


class Status:
    """Status line, enabled buttons, and the banners of emergency stop, hanging law and timing."""

    def __init__(self, panels, study, results, trial, whole, past):
        """``trial``: the ``LawTrial``, during which nothing can be done; ``whole``: the ``WholeRun``.

        ``past``: the ``PastRun``.
        """
        self._whole, self._past = whole, past
        self._panels, self._study, self._results, self._trial = panels, study, results, trial
        self._had_master, self._dismissed = False, False  # the banner of a hanging law

    def show(self):
        """Show all of it as it is now."""
        connection, bar = self._study.connection, self._panels.bar
        self._show_lines()
        stage = connection.newest("stage")
        bar.set_paused(stage is not None and stage.paused)
        bar.set_recording(self._study.processes.is_running("rosbag"))
        if connection.newest("emergency") is not None:
            bar.set_emergency(self._study.state.is_emergency())
        self.show_possible()
        self.show_alarm()
        self._show_master()
        self.show_hanging()
        self.show_timing()

    def _show_lines(self):
        for name, (good, text) in self._study.state.lines().items():
            label = self._panels.status[name]
            if name == "time" and text and self._past.remark:
                text = "{} ({})".format(text, self._past.remark)
            light = "<span style='color:{}'>\u25cf</span> {}"
            short = text.partition(":")[0] if name == "master" else text
            label.setText(light.format(GOOD[good], html.escape(short)))
            label.setToolTip(text)
            label.setVisible(bool(text))

    def show_possible(self):
        """Enable the possible actions; give the others' reasons in their tooltips."""
        panels, state = self._panels, self._study.state
        actions = state.actions()
        if self._results.can_be_saved():
            actions["save"] = True, ""
        panels.bar.show_duration(self._study.scenario.duration)
        why = self._whole.no_run()
        actions["run"] = not why, why
        panels.bar.show_singly(bool(state.real()))
        if self._trial.is_under_way:
            actions = dict.fromkeys(actions, (False, "a protocol is being loaded"))
        for name, (possible, remark) in actions.items():
            panels.bar.set_enabled(name, possible, remark)
        why, alone = state.team_locked(), state.real_alone()
        may_open = alone and not self._study.is_controlled()
        panels.team.set_editable(not why, why, may_open=may_open)
        panels.team.set_real(state.real())
        why = state.poses_locked(self._study.scenario.n)
        panels.map_panel.set_editable("poses", not why, why)
        why = state.no_push()
        panels.map_panel.set_editable("push", not why, why)
        why = state.obstacles_locked()
        panels.map_panel.set_editable("obstacles", not why, why)

    def show_alarm(self):
        """Show a banner while the emergency stop is latched."""
        self._panels.bar.bind_keys(self._panels.window())
        if self._panels.bar.is_emergency():
            self._panels.banners.notify("emergency", "alarm", LATCHED)
        else:
            self._panels.banners.clear("emergency")

    def _show_master(self):
        """Show a banner from when the master is lost until it is there again."""
        online = self._study.connection.master_online
        self._had_master = self._had_master or online
        if self._had_master and not online:
            self._panels.banners.notify("master", "error", MASTER_LOST)
        else:
            self._panels.banners.clear("master")

    def show_hanging(self):
        banners, hangs = self._panels.banners, self._study.state.hangs()
        self._dismissed, close = self._dismissed and bool(hangs), ("Close", self._dismiss)
        if self._dismissed:
            banners.clear("hangs")
        elif hangs and self._study.processes.is_running("control"):
            at = self._study.connection.newest("law_at")
            where = " at {}".format(at) if at else ""
            text = "The controller {}: its law hangs{}, or takes too long.".format(hangs, where)
            banners.notify("hangs", "error", text, ("Kill controller", self._kill), close)
        elif hangs:
            text = "The controller {}. It was started elsewhere: end it there.".format(hangs)
            banners.notify("hangs", "error", text, close)
        else:
            banners.clear("hangs")

    def _dismiss(self):
        self._dismissed = True
        self._panels.banners.clear("hangs")

    def _kill(self):
        self._panels.say(self._study.do("kill"))

    def show_timing(self):
        degraded = self._study.note_timing()
        # A slower speed helps neither a law that hangs nor a run that has ended.
        if degraded and not self._study.state.hangs() and self._study.connection.is_fresh("stage"):
            text = UNTIMELY.format(degraded[0].upper() + degraded[1:])
            self._panels.banners.notify("timing", "warning", text)
        else:
            self._panels.banners.clear("timing")
