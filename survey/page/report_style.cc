// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/report_style.h"

namespace octant::survey {

std::string_view page_style() {
  return R"(:root{color-scheme:light dark;--ink:#1b2733;--soft:#52606d;--line:#c3ccd4;--paper:#ffffff;--card:#f2f5f7;--good:#176b34;
--attention:#7a4a00;--bad:#b3261e;--link:#1660a8;--beacon:#1660a8;--control:#176b34;--track:#5d6b78;--fix:#b3470b}
@media(prefers-color-scheme:dark){:root{--ink:#dfe6ec;--soft:#a3b0bb;--line:#3a4651;--paper:#12181e;--card:#1b242c;--good:#67c587;
--attention:#e6b35c;--bad:#f2867e;--link:#6db3f2;--beacon:#6db3f2;--control:#67c587;--track:#9aa7b3;--fix:#f0945a}}
*{box-sizing:border-box}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:64rem;margin:0 auto;padding:1rem 1rem 4rem;overflow-wrap:break-word}
h1{font-size:1.8rem;line-height:1.2;margin:0}h2{font-size:1.2rem;margin:1.1rem 0 .3rem;padding-top:.4rem;border-top:1px solid var(--line)}
p{margin:.5rem 0}a{color:var(--link)}.soft{color:var(--soft)}
.skip{position:absolute;left:-999rem}.skip:focus{left:1rem;top:1rem;background:var(--paper);padding:.5rem 1rem;z-index:9}
:focus-visible{outline:3px solid var(--link);outline-offset:2px}
p.verdict{color:var(--ink);border-left:.5rem solid var(--attention);background:var(--card);padding:.5rem 1.2rem;margin:.6rem 0;font-size:1.15rem}
.verdict strong{display:block;font-size:1.5rem;line-height:1.2;color:var(--attention)}
.verdict.good{border-color:var(--good)}.verdict.good strong,.good{color:var(--good)}
.verdict.bad{border-color:var(--bad)}.verdict.bad strong,.bad{color:var(--bad)}.attention{color:var(--attention)}
nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:.2rem 1.2rem;padding:0;margin:.4rem 0;font-size:.9rem}
.scroll{overflow-x:auto;max-width:100%}
table{border-collapse:collapse;min-width:60%;margin:.6rem 0;font-size:.875rem}
caption{text-align:left;color:var(--soft);padding-bottom:.3rem;font-size:.875rem}
th,td{padding:.3rem .55rem;border-bottom:1px solid var(--line);text-align:right;vertical-align:top;font-variant-numeric:tabular-nums}
thead th{vertical-align:bottom;border-bottom:2px solid var(--soft)}th.words,td.words,tbody th{text-align:left}
tbody th{font-weight:600}td.words{overflow-wrap:anywhere;min-width:5rem}#beacon-table td.words{white-space:nowrap}#inputs td{font-family:monospace;font-size:.8rem;word-break:break-all}
figure{margin:.4rem 0}ol,ul{margin:.3rem 0}figcaption{color:var(--soft);font-size:.875rem;margin-top:.3rem}.still svg{max-width:100%;height:auto;display:block}
.live{display:none}.is-live .live{display:block}.is-live .still{display:none}
.live .textpoint text{paint-order:stroke;stroke:var(--paper);stroke-width:3px;stroke-linejoin:round}
fieldset{border:1px solid var(--line);border-radius:.4rem;padding:.2rem .8rem .5rem;margin:.6rem 0 0;display:flex;flex-wrap:wrap;gap:.1rem 1.2rem}
fieldset{min-width:0}fieldset span{overflow-wrap:anywhere}input{accent-color:var(--link)}label{cursor:pointer}details{margin:.3rem 0 1rem}summary{cursor:pointer;color:var(--link)}
footer{margin-top:3rem;color:var(--soft);font-size:.8rem}
@media(max-width:640px){.drawing{display:flex;flex-direction:column}.drawing fieldset{order:2}.drawing figure{min-width:0;margin:.4rem 0}body{font-size:15px;padding:1rem .8rem}.still svg text{font-size:20px}.still svg .legend text{font-size:13px}table{min-width:0}caption{max-width:calc(100vw - 1.8rem)}nav{display:none}h1{font-size:1.5rem}.verdict{font-size:1rem;padding:.7rem .9rem}}
@media screen and (max-width:640px){table.wide,table.wide tbody,table.wide caption{display:block;width:100%}table.wide thead{display:none}
table.wide tr{display:grid;grid-template-columns:1fr 1fr;gap:0 1rem;border-bottom:2px solid var(--line);padding:.3rem 0}
table.wide th,table.wide td,#beacon-table td.words{border:0;padding:.1rem 0;white-space:normal}table.wide th{grid-column:1/-1}
table.wide td{display:flex;justify-content:space-between;gap:.6rem;min-width:0;overflow-wrap:anywhere}table.wide td::before{color:var(--soft);text-align:left}}
@page{size:A4;margin:14mm}
@media print{body{max-width:none;padding:0;font-size:10pt}nav,.skip,.controls,fieldset{display:none}.live,.is-live .live{display:none}.is-live .still{display:block}
.scroll{overflow:visible}table{font-size:7.5pt;width:100%}#beacon-table td.words{white-space:normal}caption{font-size:8pt}th,td{padding:1.2pt 2.5pt}thead{display:table-header-group}
tr,figure,.verdict,li{break-inside:avoid}h2{break-after:avoid}.verdict,.still svg{-webkit-print-color-adjust:exact;print-color-adjust:exact}.still svg{min-width:0}}
)";
}

std::string_view page_script() {
  return R"((() => {
'use strict';
const packed = document.getElementById('plotly-js'), all = document.getElementById('all-live');
const figures = [...document.querySelectorAll('figure[data-live]')];
if (!packed || !figures.length || !('DecompressionStream' in window) || !('IntersectionObserver' in window)) return;
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
// Only where a colour is meant: a beacon may be named like one of them.
const coloured = (value, key) => typeof value === 'string' ? (key === 'color' && value.startsWith('var(') ? colour(value.slice(4, -1)) : value)
  : Array.isArray(value) ? (value.length && typeof value[0] === 'object' ? value.map(v => coloured(v, key)) : value)
  : value && typeof value === 'object' ? Object.fromEntries(Object.entries(value).map(([k, v]) => [k, coloured(v, k)])) : value;
const webgl = () => { const c = document.createElement('canvas'); return !!(c.getContext('webgl') || c.getContext('experimental-webgl')); };
const layerOf = figure => { const chosen = figure.parentElement.querySelector('fieldset input:checked'); return chosen ? Number(chosen.value) : 0; };
const axisStyle = () => ({gridcolor: colour('--line'), zerolinecolor: colour('--soft'), linecolor: colour('--line')});
let ready = null;
const load = () => ready ??= (async () => {
  const text = atob(packed.textContent.trim()), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const source = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
  const element = document.createElement('script');
  element.textContent = source;
  document.head.append(element);
  element.remove();
  packed.remove();
})();
const draw = async figure => {
  const spec = coloured(JSON.parse(document.getElementById('data-' + figure.id).textContent));
  if (spec.layout.scene && !webgl()) return;
  await load();
  const layer = layerOf(figure), narrow = window.innerWidth < 640;
  for (const trace of spec.data) if ('layer' in trace) { trace.visible = trace.layer === layer; delete trace.layer; }
  const layout = Object.assign(spec.layout, {paper_bgcolor: colour('--paper'), plot_bgcolor: colour('--paper'), hovermode: 'closest',
    font: {color: colour('--ink'), family: 'system-ui, sans-serif', size: narrow ? 11 : 13}, margin: {l: narrow ? 48 : 64, r: 16, t: 30, b: 50},
    hoverlabel: {bgcolor: colour('--card'), font: {color: colour('--ink')}}});
  if (narrow && layout.height > 400) layout.height = 440;
  if (narrow) for (const trace of spec.data) if (trace.colorbar) trace.colorbar = {thickness: 10};
  for (const axis of ['xaxis', 'yaxis']) if (layout[axis]) Object.assign(layout[axis], axisStyle());
  if (layout.scene) for (const axis of ['xaxis', 'yaxis', 'zaxis']) Object.assign(layout.scene[axis], axisStyle(), {backgroundcolor: colour('--paper')});
  figure.classList.add('is-live');
  try {
    await Plotly.react(figure.querySelector('.live'), spec.data, layout,
      {responsive: true, displaylogo: false, modeBarButtonsToRemove: ['toImage', 'lasso2d', 'select2d']});
    figure.dataset.drawn = '1';
  } catch (error) {
    figure.classList.remove('is-live');
  }
};
const watch = new IntersectionObserver(entries => {
  for (const entry of entries) if (entry.isIntersecting && all.checked) { watch.unobserve(entry.target); draw(entry.target); }
}, {rootMargin: '300px'});
const start = () => figures.forEach(figure => watch.observe(figure));
const redraw = () => figures.filter(figure => figure.classList.contains('is-live')).forEach(draw);
document.addEventListener('change', event => {
  const box = event.target.closest('.drawing');
  if (box) { const figure = box.querySelector('figure.is-live'); if (figure) draw(figure); }
});
all.addEventListener('change', () => {
  watch.disconnect();
  if (!all.checked) figures.forEach(figure => figure.classList.remove('is-live'));
  else start();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
document.querySelector('.controls').hidden = false;
start();
})();
)";
}

}  // namespace octant::survey
