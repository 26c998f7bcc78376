"""Protocols, a file each; `fieldkit.capture.protocol` finds them."""
