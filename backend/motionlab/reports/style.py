"""Style of the page: black on white in print, and light or dark on a screen."""

from __future__ import annotations

from motionlab.reports.svg_chart import LOOKS

_DARK = {
    "reference": "#97a3ad",
    "a": "#ff8a4c",
    "b": "#5cb3ec",
    "c": "#3fc49b",
    "d": "#e0b040",
    "e": "#8ecbf0",
    "one": "#a8b3bd",
    "two": "#c3a3f0",
    "phase-a": "#3fc49b",
    "phase-b": "#f0b84a",
    "phase-c": "#8ecbf0",
}

_BASE = """
:root { --text: #14181c; --quiet: #57636d; --line: #cfd6dc; --faint: #e4e8eb; --paper: #fff;
  --good: #0a6b3d; --bad: #a8201a; --band: #0000000f; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 60rem; padding: 1.5rem; background: var(--paper);
  color: var(--text); font: 14px/1.45 system-ui, sans-serif; font-variant-numeric: tabular-nums; }
h1 { font-size: 22px; line-height: 1.2; margin: 0 0 2px; overflow-wrap: anywhere; }
h2 { font-size: 16px; margin: 28px 0 6px; padding-top: 8px; border-top: 1px solid var(--line); }
h3 { font-size: 14px; margin: 16px 0 4px; }
p, dl, ul, ol { margin: 6px 0; }
.quiet, .unit, small { color: var(--quiet); }
.warning { border-left: 3px solid var(--bad); padding-left: 10px; }
.verdict { font-weight: 600; }
.good { color: var(--good); }
.bad { color: var(--bad); font-weight: 600; }
table { border-collapse: collapse; margin: 6px 0; width: 100%; font-size: 13px; }
th, td { padding: 2px 8px 2px 0; text-align: left; vertical-align: top; overflow-wrap: anywhere; }
thead th { color: var(--quiet); font-weight: 400; border-bottom: 1px solid var(--line);
  vertical-align: bottom; }
tbody th { font-weight: 400; }
tbody tr + tr > * { border-top: 1px solid var(--faint); }
.number { text-align: right; white-space: nowrap; }
th.number { text-align: right; white-space: normal; }
dl { display: grid; grid-template-columns: minmax(7rem, max-content) minmax(0, 1fr);
  gap: 2px 16px; }
dt { color: var(--quiet); }
dd { margin: 0; overflow-wrap: anywhere; }
.note { white-space: pre-line; }
pre { margin: 4px 0 10px; padding: 8px 10px; border: 1px solid var(--line); border-radius: 4px;
  font: 12px/1.45 ui-monospace, monospace; white-space: pre-wrap; overflow-wrap: anywhere; }
.printed { display: none; }
code { font: 12px ui-monospace, monospace; }
sub, sup { font-size: 75%; line-height: 0; }
figure { margin: 10px 0 18px; }
.pair, .beside { display: grid; gap: 4px 24px; }
.pair { grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); }
.beside { grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); }
svg { display: block; width: 100%; height: auto; }
svg text { fill: var(--text); }
svg .grid { stroke: var(--faint); }
svg .zero { stroke: var(--quiet); }
svg .mark { stroke: var(--quiet); }
svg .band { fill: var(--band); stroke: var(--quiet); stroke-dasharray: 3 3; }
svg .marker { fill: var(--paper); }
footer { margin-top: 32px; border-top: 1px solid var(--line); padding-top: 8px; }
"""

_SCREEN_DARK = """
:root { --text: #e3e8ec; --quiet: #9aa6b0; --line: #3a424b; --faint: #2a3139; --paper: #14181c;
  --good: #52c98a; --bad: #ff8177; --band: #ffffff14; }
"""

_PRINT = """
@page { size: A4; margin: 16mm 14mm; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  h1 { font-size: 16pt; }
  h2 { font-size: 12pt; break-after: avoid; }
  h3 { break-after: avoid; }
  table { font-size: 9pt; }
  thead { display: table-header-group; }
  tr, figure, dt, dd, .together { break-inside: avoid; }
  pre { font-size: 8pt; }
  .long { display: none; }
  .printed { display: block; color: var(--quiet); }
  .pair, .beside { grid-template-columns: 1fr 1fr; margin-block: 4px; }
  .beside dl { grid-template-columns: 22mm minmax(0, 1fr); gap: 1px 8px; font-size: 9pt; }
  .verdicts { font-size: 7.5pt; line-height: 1.2; }
  .verdicts :is(th, td) { padding-block: 1px; }
}
"""


def style() -> str:
    """Return the style sheet."""
    inks = "".join(f"svg .{look} {{ stroke: var(--ink-{look}); }}\n" for look in LOOKS)
    dark = _SCREEN_DARK + _inks(_DARK)
    return (
        f":root {{ color-scheme: light dark; }}\n{_inks(LOOKS)}{_BASE}{inks}"
        f"@media screen and (prefers-color-scheme: dark) {{{dark}}}\n{_PRINT}"
    )


def _inks(colours: dict[str, str]) -> str:
    lines = " ".join(f"--ink-{look}: {colour};" for look, colour in colours.items())
    return f":root {{ {lines} }}\n"
