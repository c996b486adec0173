// Curves over time, with a cursor laid over each.

const duration = frames.time[frames.time.length - 1];
const WHOLE = [0, duration || 1]; // the time axis of a run of a single row has a length, too
const panels = data.panels.map((panel) => ({...panel, div: document.getElementById(`panel-${panel.key}`)}));

function bandTraces(curve) {
  const edge = {x: curve.t, mode: 'lines', line: {width: 0}, hoverinfo: 'skip'};
  return [{...edge, y: curve.low}, {...edge, y: curve.high, fill: 'tonexty', fillcolor: `${curve.colour}40`}];
}

function panelTraces(panel) {
  return panel.curves.flatMap((curve) => [
    ...(curve.low ? bandTraces(curve) : []),
    {
      x: curve.t, y: curve.y, mode: 'lines', name: curve.name, opacity: data.crowd && !curve.low ? 0.7 : 1,
      line: {color: curve.colour, dash: curve.dash, width: 1.4, shape: panel.held ? 'hv' : 'linear', simplify: false},
      hovertemplate: '%{fullData.name}: %{y:.4g}<extra></extra>',
    },
  ]);
}

function valueAxis(panel, logarithmic) {
  const log = logarithmic && panel.decades;
  return axis({
    type: log ? 'log' : 'linear', nticks: 6, exponentformat: 'power',
    ...(log ? {range: log, autorange: false, dtick: 1 + Math.floor((log[1] - log[0]) / 6)}
      : panel.range ? {range: panel.range.slice(), autorange: false}
      : panel.key === 'utilisation' ? {range: [0, 1.15], autorange: false}
        : {autorange: true, rangemode: panel.decades ? 'tozero' : 'normal'}),
  });
}

function panelShapes(panel) {
  const {ink, soft, shade} = inks();
  const spells = data.spells.map(([x0, x1]) => ({
    type: 'rect', x0, x1, yref: 'paper', y0: 0, y1: 1, layer: 'below', fillcolor: shade,
    line: {width: 0.5, color: shade},
  }));
  const limits = panel.limits.map(({name, value}) => ({
    type: 'line', xref: 'paper', x0: 0, x1: 1, y0: value, y1: value, line: {color: ink, width: 0.8, dash: 'dot'},
    label: {text: name, textposition: 'end', yanchor: 'top', font: {size: 10, color: soft}},
  }));
  return [...spells, ...limits];
}

function panelLayout(panel, logarithmic) {
  return layout(panel.div, {
    hovermode: 'x unified', hoverlabel: {bgcolor: inks().paper, font: {size: 11}}, dragmode: 'zoom',
    shapes: panelShapes(panel),
    xaxis: axis({
      range: WHOLE.slice(), title: {text: 'time [s]', standoff: 4}, hoverformat: '.4g',
      unifiedhovertitle: {text: '%{x} s'},
    }),
    yaxis: valueAxis(panel, logarithmic),
  });
}

function makeCursor(div) {
  const frame = document.createElement('div');
  frame.className = 'overlay';
  Object.assign(frame.style, {
    left: `${MARGIN.l}px`, top: `${MARGIN.t}px`, right: `${MARGIN.r}px`, bottom: `${MARGIN.b}px`,
  });
  const cursor = document.createElement('div');
  cursor.className = 'cursor';
  frame.append(cursor);
  div.append(frame);
  return cursor;
}

function placeCursor(panel, time) {
  const [first, last] = panel.div.layout.xaxis.range;
  const width = panel.div.clientWidth - MARGIN.l - MARGIN.r;
  panel.cursor.style.transform = `translateX(${(time - first) / (last - first) * width - 0.75}px)`;
}
