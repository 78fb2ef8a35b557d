"""Runs as studies read them: the part, the variant, the columns, the gaps."""
