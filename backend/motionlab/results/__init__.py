"""What a run is judged by: metrics, comparison, the result document."""
