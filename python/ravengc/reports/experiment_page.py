"""How the report on the experiments looks."""

from __future__ import annotations

__all__ = ["STYLE_SHEET"]

STYLE_SHEET = """
:root { color-scheme: light; --ink: #2b2f36; --faint: #6b727c; --line: #e3e6ea; --accent: #2a7f9e; }
* { box-sizing: border-box; }
body { margin: 0; background: #f6f7f8; color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 24px 20px 60px; }
header, section { background: #fff; border: 1px solid var(--line); border-radius: 8px; padding: 20px 26px;
  margin-bottom: 18px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 20px; margin: 0 0 4px; }
h3 { font-size: 15px; margin: 22px 0 6px; }
p { margin: 6px 0; max-width: 85ch; } .source, .note, footer { color: var(--faint); font-size: 13px; }
.note { max-width: 120ch; }
nav { margin-top: 14px; display: flex; flex-wrap: wrap; gap: 6px; }
nav a { border: 1px solid var(--line); border-radius: 14px; padding: 2px 11px; font-size: 13px; }
a { color: var(--accent); text-decoration: none; } a:hover { text-decoration: underline; }
figure { margin: 14px 0; } img { width: 100%; height: auto; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; width: 100%; }
th { text-align: left; font-weight: 600; color: var(--faint); border-bottom: 2px solid var(--line); }
th, td { padding: 5px 12px 5px 0; vertical-align: top; } td { border-bottom: 1px solid var(--line); }
tr:last-child td { border-bottom: 0; }
.numbers td:not(:first-child), .numbers th:not(:first-child) { font-variant-numeric: tabular-nums; }
.findings td:last-child { min-width: 300px; color: var(--faint); }
.findings td:first-child { min-width: 190px; }
.good, .bad, .none { border-radius: 10px; padding: 1px 9px; font-size: 12px; white-space: nowrap; }
.good { background: #e2f1e4; color: #2c6b35; } .bad { background: #fbe4dd; color: #a8401c; }
.none { background: #eef0f2; color: var(--faint); }
.state { display: inline-block; }
details { margin-top: 18px; } summary { cursor: pointer; color: var(--faint); font-size: 13px; }
pre { background: #f3f4f6; border-radius: 6px; padding: 9px 12px; font-size: 13px; overflow-x: auto; }
footer { text-align: center; }
@media print { body { background: #fff; } section { break-inside: avoid-page; border: 0; } }
"""
