"""What of the window survives a restart: sizes, order and choice of its parts, and layers of the map."""

WIDTHS = (20, 10000)  # [px] that a part may have been left with
LAYOUT = ("across", "down", "views", "beside", "shown", "tabs", "front")  # names of what is kept


def saved_layout(panels):
    """Return ``LAYOUT`` as texts by name."""
    tabs = panels.results_tabs, panels.settings_tabs
    fronts = [each.currentWidget() for each in tabs]
    kept = {
        "across": panels.across.sizes(),
        "down": panels.right.sizes(),
        "views": panels.beside.sizes(),
        "beside": ["yes" if panels.view.beside.isChecked() else "no"],
        "shown": [name for name, button in panels.shown.items() if button.isChecked()],
        "tabs": panels.tab_order(),
        "front": [page.objectName() for page in fronts if page is not None],
    }
    return {name: " ".join(map(str, parts)) for name, parts in kept.items()}


def restore_layout(panels, settings):
    """Restore what ``saved_layout`` returned; invalid parts are left out."""
    kept = {name: str(settings.get(name) or "").split() for name in LAYOUT}
    if kept["beside"] in (["yes"], ["no"]):
        panels.view.beside.setChecked(kept["beside"] == ["yes"])
    splitters = panels.across.setSizes, panels.right.setSizes, panels.beside.set_sizes
    for name, set_sizes in zip(("across", "down", "views"), splitters):
        sizes = kept[name]
        if len(sizes) == 2 and all(s.isdigit() and WIDTHS[0] <= int(s) <= WIDTHS[1] for s in sizes):
            set_sizes([int(size) for size in sizes])
    if settings.get("shown") is not None:
        for name, button in panels.shown.items():
            button.setChecked(name in kept["shown"])
    panels.set_tab_order(kept["tabs"])
    for name in kept["front"]:
        panels.bring_forward(name)
