"""Synthetic sample logs from descriptions of their formats: a module per logger or family, which binds `MAKERS`.

A flight is simulated, measured by a device with its noise, resolution and clock, and written in its format. The same
call writes the same bytes; nothing comes from a real log.
"""
