// Style sheet of reports. For the sources of this folder only.
#pragma once

namespace tessera::client {

/// Light and dark; on paper always light. fill-NAME and stroke-NAME are those of plot/canvas.h. It is free of
/// "<" and "&", which the page's XML could not hold.
inline constexpr const char kReportStyle[] = R"css(
:root { --ground: #fff; --ink: #1c1f24; --soft: #5c6570; --line: #dcdfe3; --data: #0072b2; --warn: #96610a;
  --card: #f7f7f5; }
@media screen and (prefers-color-scheme: dark) {
  :root { --ground: #15171a; --ink: #e8eaed; --soft: #a0a8b3; --line: #32373e; --data: #56b4e9;
    --warn: #e8b45a; --card: #1d2024; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 24px 20px 48px; background: var(--ground);
  color: var(--ink); font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 26px; margin: 0 0 10px; overflow-wrap: anywhere; }
h2 { font-size: 18px; margin: 34px 0 8px; border-bottom: 1px solid var(--line); padding-bottom: 4px;
  overflow-wrap: anywhere; }
.facts { display: flex; flex-wrap: wrap; gap: 6px 28px; margin: 8px 0 14px; }
.facts dt { color: var(--soft); font-size: 12.5px; }
.facts dd { margin: 0; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.warnings { border-left: 4px solid var(--warn); padding-left: 14px; }
.warnings h2 { border: 0; margin-bottom: 0; color: var(--warn); }
.warnings summary { color: var(--warn); }
figure { margin: 0 0 12px; }
figcaption { color: var(--soft); font-size: 13px; }
svg { display: block; max-width: 100%; height: auto; font-family: system-ui, sans-serif; }
.map svg { width: 100%; max-width: 860px; }
.diagrams { display: grid; gap: 8px 20px;
  grid-template-columns: repeat(auto-fit, minmax(min(300px, 100%), 1fr)); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 4px 12px 4px 0; border-bottom: 1px solid var(--line);
  vertical-align: top; }
th { color: var(--soft); font-weight: 600; font-size: 12.5px; }
.number { text-align: right; white-space: nowrap; }
summary { cursor: pointer; margin: 10px 0; }
.fill-ink { fill: var(--ink); } .fill-soft { fill: var(--soft); } .fill-data { fill: var(--data); }
.fill-grid { fill: var(--line); } .fill-ground { fill: var(--ground); }
.stroke-ink { stroke: var(--ink); } .stroke-soft { stroke: var(--soft); }
.stroke-data { stroke: var(--data); } .stroke-grid { stroke: var(--line); }
.stroke-ground { stroke: var(--ground); }
@media print {
  body { max-width: none; padding: 0; font-size: 11pt; }
  section.plane, figure, tr { break-inside: avoid; }
  .wide { overflow: visible; }
}
)css";

}  // namespace tessera::client
