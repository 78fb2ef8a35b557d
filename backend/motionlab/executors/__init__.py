"""Where the tasks of a study are computed: threads, worker processes, or a Dask cluster."""
