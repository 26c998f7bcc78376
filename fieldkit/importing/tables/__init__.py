"""Building blocks of parsers: text, rows and columns, clocks, headers, and units inferred from physics."""
