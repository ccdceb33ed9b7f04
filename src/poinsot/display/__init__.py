"""Presentation of objects: text and HTML summaries, typeset formulas, progress bars."""
