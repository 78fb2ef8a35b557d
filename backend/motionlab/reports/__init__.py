"""A run or a comparison of two as one HTML file: without scripts, images or fonts of elsewhere."""
