"""Sample logs made up from descriptions of their formats: a module per logger or family, which binds `MAKERS`.

A flight is simulated, a device sees it through its own barometer, with its noise, its steps and its clock, and writes
it down in its own form. The same call writes the same bytes, and nothing is from a real log.
"""
