"""What of the window survives a restart: sizes of its parts, and layers of the map."""

WIDTHS = (20, 10000)  # [px] that a part may have been left with


def saved_layout(panels):
    """Return sizes and layers as texts by name."""
    return {
        "across": " ".join(map(str, panels.across.sizes())),
        "down": " ".join(map(str, panels.right.sizes())),
        "shown": " ".join(name for name, button in panels.shown.items() if button.isChecked()),
    }


def restore_layout(panels, settings):
    """Restore what ``saved_layout`` returned; invalid parts are left out."""
    for key, splitter in (("across", panels.across), ("down", panels.right)):
        sizes = str(settings.get(key, "")).split()
        if len(sizes) == 2 and all(s.isdigit() and WIDTHS[0] <= int(s) <= WIDTHS[1] for s in sizes):
            splitter.setSizes([int(s) for s in sizes])
    if settings.get("shown") is not None:
        wanted = str(settings["shown"]).split()
        for name, button in panels.shown.items():
            button.setChecked(name in wanted)
