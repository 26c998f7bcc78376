"""Logs as people change them: columns renamed, units mixed, counters that wrap, sensors that are stuck."""
