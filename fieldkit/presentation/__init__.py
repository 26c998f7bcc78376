"""One rendering of each result per medium: text, JSON documents, tables, pages."""
