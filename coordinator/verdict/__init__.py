"""The verdict of a run."""
