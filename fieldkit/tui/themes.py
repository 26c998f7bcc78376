"""Color schemes of the app: for a room, for bright sun, for the dark, and the terminal's.

Colors repeat states that symbols show (`fieldkit.tui.widgets.states`), so a scheme may have few.
"""

from collections.abc import Mapping

from textual.theme import BUILTIN_THEMES, Theme

INKS = """text text-muted text-disabled foreground-muted foreground-disabled footer-foreground footer-key-foreground
text-primary text-secondary text-warning text-error text-success text-accent footer-description-foreground border
input-cursor-background block-cursor-background block-cursor-blurred-background scrollbar scrollbar-hover
scrollbar-active screen-selection-background input-selection-background link-color"""
PAPERS = """block-cursor-foreground block-cursor-blurred-foreground input-cursor-foreground scrollbar-background
scrollbar-background-hover scrollbar-background-active footer-background footer-key-background boost surface-active
footer-description-background screen-selection-foreground input-selection-foreground block-hover-background
link-background scrollbar-corner-color button-color-foreground"""
"""Textual's color variables for foreground, and those for background, in a two-color scheme."""


def _flat(ink: str, paper: str, line: str) -> dict[str, str]:
    """The variables of a scheme in which all text is equally bright: one foreground, one background, one border."""
    return {
        **dict.fromkeys(INKS.split(), ink),
        **dict.fromkeys(PAPERS.split(), paper),
        "border-blurred": line,
        "backdrop": paper,
        "block-cursor-text-style": "bold",
        "block-cursor-blurred-text-style": "none",
        "input-cursor-text-style": "none",
    }


FIELD = Theme(
    name="field",
    primary="#8fd0ff",
    secondary="#b9c7d8",
    accent="#ffc66d",
    warning="#ffd479",
    error="#ff9b8f",
    success="#98e6ad",
    foreground="#eef3f8",
    background="#0e141b",
    surface="#141c25",
    panel="#1d2833",
    boost="#243240",
    dark=True,
    variables={
        "text-muted": "#b4c2d0",
        "text-disabled": "#b4c2d0",
        "foreground-muted": "#b4c2d0",
        "border": "#8fd0ff",
        "border-blurred": "#4a5d70",
        "backdrop": "#0e141b 70%",
        "block-cursor-background": "#8fd0ff",
        "block-cursor-foreground": "#0b1117",
        "block-cursor-text-style": "bold",
        "block-cursor-blurred-background": "#2b3b4b",
        "block-cursor-blurred-foreground": "#eef3f8",
        "footer-background": "#1d2833",
        "footer-key-foreground": "#ffc66d",
        "input-cursor-background": "#ffc66d",
        "input-cursor-foreground": "#0b1117",
        "input-cursor-text-style": "none",
        "input-selection-background": "#2b3b4b",
        "input-selection-foreground": "#eef3f8",
        "scrollbar": "#4a5d70",
        "scrollbar-background": "#141c25",
    },
)
SUN = Theme(
    name="sun",
    primary="#000000",
    secondary="#000000",
    accent="#00226b",
    warning="#5c3300",
    error="#7a0000",
    success="#003d12",
    foreground="#000000",
    background="#ffffff",
    surface="#ffffff",
    panel="#ffffff",
    dark=False,
    text_alpha=1.0,
    luminosity_spread=0.0,
    variables=_flat("#000000", "#ffffff", "#000000"),
)
NIGHT_INK = "#ff6f64"
"""A red that is seven times as bright as black, in WCAG's measure, and spares eyes that are used to the dark."""
NIGHT = Theme(
    name="night",
    primary=NIGHT_INK,
    secondary=NIGHT_INK,
    accent=NIGHT_INK,
    warning="#ff9a4d",
    error="#ff8080",
    success="#ffb499",
    foreground=NIGHT_INK,
    background="#000000",
    surface="#000000",
    panel="#000000",
    dark=True,
    text_alpha=1.0,
    luminosity_spread=0.0,
    variables=_flat(NIGHT_INK, "#000000", "#8a1a12"),
)
TERMINAL = Theme(
    name="terminal",
    ansi=True,
    primary="ansi_default",
    secondary="ansi_default",
    accent="ansi_default",
    warning="ansi_magenta",
    error="ansi_red",
    success="ansi_green",
    foreground="ansi_default",
    background="ansi_default",
    surface="ansi_default",
    panel="ansi_default",
    boost="ansi_default",
    variables=BUILTIN_THEMES["ansi-dark"].variables
    | dict.fromkeys([*INKS.split(), *PAPERS.split(), "border-blurred"], "ansi_default")
    | {"block-cursor-text-style": "reverse", "block-cursor-blurred-text-style": "reverse"}
    | {"input-cursor-text-style": "reverse", "backdrop": "ansi_default"},
)
THEMES: Mapping[str, Theme] = {theme.name: theme for theme in (FIELD, SUN, NIGHT, TERMINAL)}
"""Color schemes by their names in the settings."""
