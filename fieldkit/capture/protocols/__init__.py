"""Protocols, one file each; `fieldkit.capture.protocol` finds them."""
