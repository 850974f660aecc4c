"""Connects the panel of programs with the programs."""

from mrs_simulator.rqt_plugin.run.programs import Programs
from mrs_simulator.rqt_plugin.widgets.guard import guarded


@guarded
class ProgramControl:
    """Passes requests of the panel to the programs, and shows their states while visible."""

    def __init__(self, panels, study):
        self._panels, self._study, self.programs = panels, study, Programs(study)
        panels.programs.asked.connect(self._on_asked)
        panels.programs.added.connect(self._on_added)

    def _on_asked(self, action, name):
        self._panels.close_error()  # that of what was done before
        if action == "remove":
            self.programs.remove(name)
        elif action == "start":
            self._panels.say(self.programs.start(name, self._panels.bar.speed()))
        else:
            self._panels.say(getattr(self.programs, action)(name))
        self.show()

    def _on_added(self, command):
        known = {program.name for program in self.programs.all()}
        if self._panels.say(self.programs.add(command)):
            return
        self._panels.programs.command.clear()
        self.show()
        for program in self.programs.all():
            if program.name not in known:
                self._panels.programs.select(program.name)

    def follow(self):
        """Restart programs that have ended for it; show the programs while visible."""
        for message in self.programs.follow(self._panels.bar.speed()):
            self._panels.say(message)
        looked_at = self._panels.programs.isVisible() or self._panels.sensors.isVisible()
        self._study.connection.watch_diagnostics(looked_at)
        if self._panels.programs.isVisible():
            self.show()

    def show(self):
        """Show all programs as they are now."""
        panel, programs = self._panels.programs, self.programs.all()
        users = [program.name for program in programs if self.programs.is_users(program.name)]
        panel.show_programs(programs, users)
        panel.show_output(self.programs.output(panel.selected) if panel.selected else "")
        panel.show_diagnostics(self._study.connection.diagnostics())
