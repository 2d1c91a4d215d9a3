(() => {
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
