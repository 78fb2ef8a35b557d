"""How many simulations run at once."""

from __future__ import annotations

import asyncio

from fastapi import HTTPException, Request


def free_slot(request: Request) -> asyncio.Semaphore:
    """Return what a simulation holds while it runs, or answer 429 where all are held."""
    slots: asyncio.Semaphore = request.app.state.slots
    if slots.locked():
        raise HTTPException(
            429, f"{request.app.state.settings.running_max} simulations run already"
        )
    return slots
