"""A software EtherCAT segment of six current drives with the simulated motor behind them."""
