"""Counts for Prometheus, at /metrics; names follow its conventions: prefix, base units, _total."""

from __future__ import annotations

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    disable_created_metrics,
    generate_latest,
)

disable_created_metrics()  # a second line for each count, with the time at which it began


class Monitor:
    """The counters of one application."""

    def __init__(self) -> None:
        self.registry = into = CollectorRegistry()
        self.simulations = Counter(
            "motionlab_simulations",
            "Runs answered by simulate, whatif and jobs",
            registry=into,
        )
        self.simulation_seconds = Histogram(
            "motionlab_simulation_duration_seconds",
            "Time that simulate and whatif took",
            buckets=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0),
            registry=into,
        )
        self.sessions = Gauge("motionlab_sessions", "Live sessions", registry=into)
        self.clients = Gauge("motionlab_stream_clients", "Clients of streams", registry=into)
        self.frames = Counter("motionlab_stream_frames", "Frames sent", registry=into)
        self.dropped = Counter(
            "motionlab_stream_frames_dropped",
            "Frames skipped for slow clients",
            registry=into,
        )

    def text(self) -> bytes:
        """Return all counts in Prometheus' text format."""
        return generate_latest(self.registry)
