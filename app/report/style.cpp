#include "app/report/style.h"

namespace limberg {

const char* const report_style = R"css(
:root{--paper:#fff;--card:#f5f7f8;--ink:#1c2529;--soft:#5a686e;--grid:#dfe5e7;--accent:#0b6b74;--good:#1a7f4b;--warn:#b26a00;--bad:#b3261e;
--s1:#0072b2;--s2:#d55e00;--s3:#009e73;--s4:#b1568b;--s5:#b98200;--s6:#3a93c9;color-scheme:light}
@media (prefers-color-scheme:dark){:root{--paper:#12181b;--card:#1b2428;--ink:#e6edef;--soft:#9fb0b6;--grid:#2f3b40;--accent:#58c3cd;--good:#5ccf93;
--warn:#f0b357;--bad:#ff8a80;--s1:#5ab4f0;--s2:#ff9a56;--s3:#4fd3a8;--s4:#e59cc8;--s5:#f0c45a;--s6:#8fd0f5;color-scheme:dark}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%}
body{margin:0 auto;max-width:1080px;padding:24px 20px 64px;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
h1{font-size:clamp(1.6rem,5vw,2.3rem);line-height:1.15;margin:0 0 4px;letter-spacing:-.01em}
h2{font-size:1.3rem;margin:46px 0 12px;padding-top:10px;border-top:1px solid var(--grid)}
details{margin:14px 0;padding-top:10px;border-top:1px solid var(--grid)}
summary{cursor:pointer;font-size:1.15rem;font-weight:600}
h3{font-size:1.02rem;margin:22px 0 6px}
p{margin:8px 0;max-width:75ch}
.soft,figcaption,.note{color:var(--soft)}
.note{font-size:.9rem}
.verdict{display:flex;gap:14px;align-items:flex-start;margin:18px 0 20px;padding:14px 18px;background:var(--card);border-left:6px solid var(--soft);border-radius:6px;font-size:1.08rem}
.verdict.good{border-color:var(--good)}.verdict.warn{border-color:var(--warn)}.verdict.bad{border-color:var(--bad)}
.notice{margin:14px 0;padding:10px 16px;background:var(--card);border-left:6px solid var(--warn);border-radius:6px}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(168px,1fr));gap:12px;margin:18px 0}
.card{background:var(--card);border-radius:8px;padding:12px 14px}
.card b{display:block;font-size:1.32rem;line-height:1.25;font-variant-numeric:tabular-nums;overflow-wrap:anywhere}
.card span{font-size:.86rem;color:var(--soft)}
.card .why{display:block;margin-top:2px}
figure{margin:0}
figure img{display:block;width:100%;height:auto;border-radius:8px;background:#2c424a}
.onchart{max-width:760px;margin:10px 0}
.onchart img{background:#fff}
figcaption{font-size:.92rem;margin:6px 2px 0}
figcaption b{color:var(--ink)}
.hero{margin:18px 0}
.story{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,320px),1fr));gap:22px 18px}
.pairs{grid-template-columns:1fr 1fr}
/* What is wider than the page scrolls by itself, and a shadow at the edge says so. */
.wide{overflow-x:auto;background:linear-gradient(to left,var(--paper) 40%,transparent) 100% 0/48px 100% no-repeat local,
linear-gradient(to left,#0003,transparent) 100% 0/14px 100% no-repeat scroll}
table{border-collapse:collapse;width:100%;margin:10px 0;font-variant-numeric:tabular-nums;font-size:.95rem}
th,td{padding:6px 12px;text-align:right;border-bottom:1px solid var(--grid);white-space:nowrap}
th:first-child,td:first-child{text-align:left}
th{font-weight:600;color:var(--soft);font-size:.88rem;vertical-align:bottom}
.bars th:last-child,.bars td:last-child{text-align:left;white-space:normal;min-width:15em;font-size:.88rem;color:var(--soft)}
.bars td:first-child{white-space:normal;min-width:11em}
td.bar{width:40%;min-width:110px;padding-left:0}
.meter{display:block;height:10px;border-radius:5px;background:currentColor;min-width:2px}
.light{display:inline-block;width:.72em;height:.72em;border-radius:50%;background:currentColor;margin-right:.45em}
.good{color:var(--good)}.warn{color:var(--warn)}.bad{color:var(--bad)}
.verdict.good,.verdict.warn,.verdict.bad{color:var(--ink)}
svg.chart{display:block;width:100%;height:auto;margin:10px 0;max-width:900px}
pre{background:var(--card);border-radius:8px;padding:12px 14px;overflow-x:auto;font:13px/1.5 ui-monospace,"DejaVu Sans Mono",Consolas,monospace;max-height:420px;overflow-y:auto}
code{font:.92em ui-monospace,"DejaVu Sans Mono",Consolas,monospace}
a{color:var(--accent)}
footer{margin-top:48px;padding-top:12px;border-top:1px solid var(--grid);font-size:.86rem;color:var(--soft);overflow-wrap:anywhere}
footer:empty{display:none}
@media (max-width:640px){body{padding:16px 12px 40px}th,td{padding:6px 7px}td.bar,th.bar{display:none}.phone{display:none}
td:first-child,th{white-space:normal}td:first-child code{overflow-wrap:anywhere}.pairs{gap:14px 8px}.bars td:first-child{min-width:7em}svg.chart{min-width:600px}}
@media print{:root{--paper:#fff;--card:#f3f5f6;--ink:#000;--soft:#444;--grid:#ccc;--good:#1a7f4b;--warn:#b26a00;--bad:#b3261e;--s1:#0072b2;--s2:#d55e00;--s3:#009e73;color-scheme:light}
body{max-width:none;padding:0;font-size:11pt}h2{margin-top:22pt}figure,tr,.card,svg.chart,.verdict{break-inside:avoid}thead{display:table-header-group}.cards{grid-template-columns:repeat(3,1fr)}.hero img{max-height:9cm;width:auto}.onchart img,.onchart svg{max-height:9cm}h2,h3{break-after:avoid}
pre{max-height:none;white-space:pre-wrap;overflow-wrap:anywhere;overflow:visible}.wide{overflow:visible;background:none}td:first-child,th{white-space:normal}.story{grid-template-columns:1fr 1fr 1fr;gap:10px}.pairs{grid-template-columns:1fr 1fr}th,td{padding:3px 10px}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
)css";

}  // namespace limberg
