"""The sampled loop, linearised: margins, stability boundary, frequency sweep."""
