// Curves over time, with a cursor laid over each.

const duration = frames.time[frames.time.length - 1];
const WHOLE = [0, duration || 1]; // the time axis of a run of a single row has a length, too
const NAME = {step: 13, font: '11px system-ui, sans-serif', longest: 120}; // [px] of names at the curves
const PANEL_MARGIN = {...MARGIN, r: nameRoom()};
const panels = data.panels.map((panel) => ({...panel, div: document.getElementById(`panel-${panel.key}`)}));

function bandTraces(curve, place) {
  const edge = {x: curve.t, mode: 'lines', line: {width: 0}, hoverinfo: 'skip'};
  const [low, high] = [curve.low, curve.high].map((values) => values.map(place));
  return [{...edge, y: low}, {...edge, y: high, fill: 'tonexty', fillcolor: `${curve.colour}40`}];
}

// A panel with a knee is linear up to it and logarithmic beyond, as `nhtrack.presentation.bend` says.
function bent(value, knee) {
  if (value === null) return null;
  const size = Math.abs(value) / knee;
  return Math.sign(value) * (size <= 1 ? size : 1 + Math.log10(size));
}

function isLogarithmic() {
  return chosen('axis', 'log') === 'log';
}

// Where a panel's axis has a value: a function, since to ask the page for every value what was chosen costs more than a plot.
function placing({knee}) {
  return knee && isLogarithmic() ? (value) => bent(value, knee) : (value) => value;
}

function panelTraces(panel) {
  const place = placing(panel);
  return panel.curves.flatMap((curve) => [
    ...(curve.low ? bandTraces(curve, place) : []),
    {
      x: curve.t, y: curve.y.map(place), customdata: curve.y, mode: 'lines', name: curve.name, opacity: data.crowd && !curve.low ? 0.7 : 1,
      line: {color: curve.colour, dash: curve.dash, width: 1.4, shape: panel.held ? 'hv' : 'linear', simplify: false},
      hovertemplate: '%{fullData.name}: %{customdata:.4g}<extra></extra>',
    },
  ]);
}

function valueAxis(panel) {
  const log = isLogarithmic() && panel.decades;
  const place = placing(panel);
  const ticks = panel.knee && isLogarithmic() ? panel.ticks : null;
  return axis({
    ...(ticks && {tickvals: ticks.map(place), ticktext: ticks.map(short)}),
    type: log ? 'log' : 'linear', nticks: 6, exponentformat: 'power',
    ...(log ? {range: log, autorange: false, dtick: 1 + Math.floor((log[1] - log[0]) / 6)}
      : panel.range ? {range: panel.range.slice(), autorange: false}
      : panel.key === 'utilisation' ? {range: [0, place(1.15)], autorange: false}
        : {autorange: true, rangemode: panel.decades ? 'tozero' : 'normal'}),
  });
}

function panelShapes(panel) {
  const {ink, soft, shade} = inks();
  const place = placing(panel);
  const spells = data.spells.map(([x0, x1]) => ({
    type: 'rect', x0, x1, yref: 'paper', y0: 0, y1: 1, layer: 'below', fillcolor: shade,
    line: {width: 0.5, color: shade},
  }));
  const limits = panel.limits.map(({name, value}) => ({
    type: 'line', xref: 'paper', x0: 0, x1: 1, y0: place(value), y1: place(value), line: {color: ink, width: 0.8, dash: 'dot'},
    label: {text: name, textposition: 'end', yanchor: 'top', font: {size: 10, color: soft}},
  }));
  const knees = (panel.knee && isLogarithmic() ? [1, -1] : []).filter((side) => panel.ticks.includes(side * panel.knee));
  const bends = knees.map((y) => ({
    type: 'line', xref: 'paper', x0: 0, x1: 1, y0: y, y1: y, layer: 'below', line: {color: soft, width: 1, dash: '1px,3px'},
  }));
  return [...spells, ...bends, ...limits];
}

function panelLayout(panel) {
  return layout(panel.div, {
    margin: PANEL_MARGIN,
    hovermode: 'x unified', hoverlabel: {bgcolor: inks().paper, font: {size: 11}}, dragmode: 'zoom',
    shapes: panelShapes(panel),
    xaxis: axis({
      range: WHOLE.slice(), title: {text: 'time [s]', standoff: 4}, hoverformat: '.4g',
      unifiedhovertitle: {text: '%{x} s'},
    }),
    yaxis: valueAxis(panel),
  });
}

function makeCursor(div) {
  const frame = document.createElement('div');
  frame.className = 'overlay';
  Object.assign(frame.style, {
    left: `${MARGIN.l}px`, top: `${MARGIN.t}px`, right: `${PANEL_MARGIN.r}px`, bottom: `${MARGIN.b}px`,
  });
  const cursor = document.createElement('div');
  cursor.className = 'cursor';
  frame.append(cursor);
  div.append(frame);
  return cursor;
}

function placeCursor(panel, time) {
  const [first, last] = panel.div.layout.xaxis.range;
  const width = panel.div.clientWidth - MARGIN.l - PANEL_MARGIN.r;
  panel.cursor.style.transform = `translateX(${(time - first) / (last - first) * width - 0.75}px)`;
}

// Room beside panels for the longest name of a curve [px].
function nameRoom() {
  const pen = document.createElement('canvas').getContext('2d');
  pen.font = NAME.font;
  const names = data.panels.flatMap(({curves}) => curves.map(({name}) => name));
  return 16 + Math.min(NAME.longest, Math.max(0, ...names.map((name) => Math.ceil(pen.measureText(name).width))));
}

function makeNames(panel) {
  const names = panel.curves.map(({name, colour}) => {
    const label = document.createElement('span');
    Object.assign(label, {className: 'name', textContent: name, title: name});
    label.style.setProperty('--colour', colour);
    return label;
  });
  const frame = document.createElement('div');
  frame.className = 'names';
  Object.assign(frame.style, {top: `${MARGIN.t}px`, width: `${PANEL_MARGIN.r - 6}px`, bottom: `${MARGIN.b}px`});
  frame.append(...names);
  panel.div.append(frame);
  return names;
}

// Puts names as high as their curves end in the part that is shown, one below the other.
function placeNames(panel) {
  if (!panel.names) return;
  const {xaxis, yaxis} = panel.div.layout;
  const height = panel.div.clientHeight - MARGIN.t - MARGIN.b;
  const [low, high] = yaxis.range;
  const placed = placing(panel);
  const ends = panel.curves.map(({t, y}) => {
    let row = t.length - 1;
    while (row > 0 && (t[row] > xaxis.range[1] || y[row] === null)) row -= 1;
    const value = yaxis.type === 'log' ? Math.log10(Math.max(y[row], 1e-300)) : placed(y[row] ?? 0);
    return Math.min(Math.max((high - value) / (high - low), 0), 1) * height;
  });
  const fit = panel.names.length * NAME.step <= height + NAME.step;
  apart(ends, NAME.step, height).forEach((place, curve) => {
    panel.names[curve].style.display = fit ? '' : 'none';
    panel.names[curve].style.transform = `translateY(calc(${place}px - 50%))`;
  });
}

// Places moved apart to at least a step, in the same order and none below the last.
function apart(places, step, last) {
  const order = [...places.keys()].sort((one, other) => places[one] - places[other]);
  const moved = [...places];
  let next = -Infinity;
  for (const k of order) {
    moved[k] = Math.max(moved[k], next);
    next = moved[k] + step;
  }
  next = last;
  for (const k of order.reverse()) {
    moved[k] = Math.min(moved[k], next);
    next = moved[k] - step;
  }
  return moved;
}
