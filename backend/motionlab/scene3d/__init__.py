"""The 3-D view: a viser server in a process of its own; docs/3d-view.md."""
