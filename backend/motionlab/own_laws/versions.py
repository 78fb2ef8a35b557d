"""The versions of a law's file that a server has taken, and which of them runs."""

from __future__ import annotations

from dataclasses import dataclass

MOST = 20
"""Versions that are kept of a law; the oldest goes."""


@dataclass(frozen=True)
class Versions:
    """Versions of the file of a law, in the order in which they were taken.

    Attributes
    ----------
    texts : tuple of str
        Of each; no two are alike.
    number : int
        Of the one that runs, from 1.
    """

    texts: tuple[str, ...]
    number: int = 1

    @property
    def running(self) -> str:
        """Text of the version that runs."""
        return self.texts[self.number - 1]

    @property
    def before(self) -> str:
        """Text of the version before it; of the first, its own."""
        return self.texts[max(0, self.number - 2)]

    def saved(self, text: str) -> Versions:
        """Return them with a version that is taken now, which follows the one that ran."""
        last = [self.running] if text != self.running else []
        others = [each for each in self.texts if each not in {text, self.running}]
        texts = (*others, *last, text)[-MOST:]
        return Versions(texts, len(texts))

    def moved(self, by: int) -> Versions | None:
        """Return them with another one running, so many later, or None where there is none."""
        number = self.number + by
        return Versions(self.texts, number) if 1 <= number <= len(self.texts) else None
