"""Drives in a server: routes, sessions on drives, commissioning, and the link behind them."""
