"""Counts for Prometheus, at /metrics; names follow its conventions: prefix, base units, _total."""

from __future__ import annotations

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest


class Monitor:
    """The counters of one application."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.simulations = Counter(
            "psrm_simulations", "Runs answered by simulate, whatif and jobs", registry=self.registry
        )
        self.simulation_seconds = Histogram(
            "psrm_simulation_duration_seconds",
            "Time that simulate and whatif took",
            buckets=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0),
            registry=self.registry,
        )
        self.sessions = Gauge("psrm_sessions", "Live sessions", registry=self.registry)
        self.clients = Gauge("psrm_stream_clients", "Clients of streams", registry=self.registry)
        self.frames = Counter("psrm_stream_frames", "Frames sent", registry=self.registry)
        self.dropped = Counter(
            "psrm_stream_frames_dropped", "Frames skipped for slow clients", registry=self.registry
        )

    def text(self) -> bytes:
        """Return all counts in Prometheus' text format."""
        return generate_latest(self.registry)
