"""The stage in three dimensions: a viser server in a process of its own; docs/stage.md."""
