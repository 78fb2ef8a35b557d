"""The compiled control period: lane parameters, one tick, scoring of batches."""
