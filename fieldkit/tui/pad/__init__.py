"""The pad: a checklist, and the contest's timer."""
