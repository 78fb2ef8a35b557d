"""The 3-D view: a viser process for each session that is watched, behind a proxy."""
