// The floor and the robots on it. Robots are laid over what Plotly draws, since moving them is then a matter of a
// transform, not of drawing a plot anew.

const frames = data.frames;
const LEAST_ROBOT = data.crowd ? 15 : 26; // [px] smaller robots are drawn larger than they are, and the page says so
const PATCH_NAME = 110; // [px] that the name of a patch may need
const floor = document.getElementById('floor');

// Whether the trajectories of `pose` (what ran) or `twin` are among those to be seen.
function isShown(kind) {
  const shown = chosen('shown', 'main');
  return shown === 'both' || (shown === 'twin') === (kind === 'twin');
}

// A robot's path up to the time that is shown.
function soFar(kind, place) {
  return ['x', 'y'].map((side) => frames[kind][side][place].slice(0, state.frame + 1));
}

function paths(kind, look) {
  return data.robots.map((robot, place) => ({
    x: soFar(kind, place)[0], y: soFar(kind, place)[1], mode: 'lines', name: robot.name, meta: kind,
    visible: isShown(kind),
    hovertemplate: `%{fullData.name}<br>%{x:.4g} m, %{y:.4g} m<extra>${kind === 'twin' ? 'ideal twin' : ''}</extra>`,
    ...look(robot, place),
  }));
}

function floorTraces() {
  const thin = (place) => (data.crowd && place ? 1 : place ? 2 : 3);
  const main = paths('pose', (robot, place) => ({
    line: {color: robot.colour, dash: robot.dash, width: thin(place), simplify: false}, opacity: data.crowd && place ? 0.6 : 1,
  }));
  if (!data.twin) return main;
  const twin = paths('twin', (robot, place) => ({
    line: {
      color: data.crowd ? robot.colour : inks().ink, width: 1, dash: data.crowd ? 'dot' : '5px,7px', simplify: false,
    },
  }));
  return [...main, ...twin];
}

// While time moves, a canvas over the plot has the paths so far; Plotly draws them when it has stood still for a while.
const STILL = 200; // [ms]
const trails = {canvas: null, waiting: null};

function makeTrails() {
  trails.canvas = document.createElement('canvas');
  trails.canvas.className = 'overlay trails';
  floor.append(trails.canvas);
}

function moveTrails() {
  if (!trails.canvas) return;
  floor.classList.add('moving');
  clearTimeout(trails.waiting);
  trails.waiting = setTimeout(settleTrails, STILL);
}

async function settleTrails() {
  const shown = floor.data.map(({meta}, trace) => soFar(meta, trace % data.robots.length));
  await Plotly.restyle(floor, {x: shown.map(([x]) => x), y: shown.map(([, y]) => y)});
  if (trails.waiting) floor.classList.remove('moving');
}

// Lengths of dashes and gaps [px], as a canvas wants them, of a line that Plotly knows by a word or by its lengths.
function dashesOf(dash, width) {
  if (!dash || dash === 'solid') return [];
  return dash === 'dot' ? [width, width] : dash.split(',').map(parseFloat);
}

function drawTrails() {
  if (!trails.canvas || !floor.classList.contains('moving')) return;
  const {canvas} = trails;
  const [width, height] = [floor.clientWidth - MARGIN.l - MARGIN.r, floor.clientHeight - MARGIN.t - MARGIN.b];
  const dense = window.devicePixelRatio;
  Object.assign(canvas, {width: Math.round(dense * width), height: Math.round(dense * height)});
  Object.assign(canvas.style, {left: `${MARGIN.l}px`, top: `${MARGIN.t}px`, width: `${width}px`, height: `${height}px`});
  const [[left, right], [bottom, top]] = [floor.layout.xaxis.range, floor.layout.yaxis.range];
  const brush = canvas.getContext('2d');
  brush.scale(dense, dense);
  brush.lineJoin = 'round';
  floor.data.forEach(({meta, line, opacity, visible}, trace) => {
    if (visible === false) return;
    const [xs, ys] = ['x', 'y'].map((side) => frames[meta][side][trace % data.robots.length]);
    brush.globalAlpha = opacity ?? 1;
    brush.strokeStyle = line.color;
    brush.lineWidth = line.width;
    brush.setLineDash(dashesOf(line.dash, line.width));
    brush.beginPath();
    let known = false;
    for (let k = 0; k <= state.frame; k += 1) {
      if (xs[k] !== null) {
        const [x, y] = [(xs[k] - left) / (right - left) * width, (top - ys[k]) / (top - bottom) * height];
        if (known) brush.lineTo(x, y);
        else brush.moveTo(x, y);
      }
      known = xs[k] !== null;
    }
    brush.stroke();
  });
}

// Equal axes: the smallest ranges around all that is to be seen in which a metre is as long along x as along y.
function floorRanges() {
  const sides = ['x', 'y'].map((side) => {
    const kinds = data.twin ? ['pose', 'twin'] : ['pose'];
    let [low, high] = [Infinity, -Infinity];
    for (const value of kinds.flatMap((kind) => frames[kind][side]).flat()) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    return withPatches(low, high, side);
  });
  floor.style.setProperty('--wanted', `${wantedHeight(sides)}px`);
  const size = [floor.clientWidth - MARGIN.l - MARGIN.r, floor.clientHeight - MARGIN.t - MARGIN.b];
  const metres = Math.max(...sides.map(([low, high], k) => (high - low) / (size[k] - 2 * LEAST_ROBOT)), 1e-6);
  return sides.map(([low, high], k) => [-1, 1].map((sign) => (low + high) / 2 + sign * metres * size[k] / 2));
}

// How high the plot has to be for all of it to be seen over its whole width [px].
function wantedHeight([x, y]) {
  const [width, room] = [floor.clientWidth - MARGIN.l - MARGIN.r, 2 * LEAST_ROBOT];
  return (width - room) * (y[1] - y[0]) / Math.max(x[1] - x[0], 1e-6) + room + MARGIN.t + MARGIN.b;
}

// The sides of a patch [m]: x from, to, y from, to.
function sidesOf({rectangle, disc}) {
  return rectangle ?? [disc[0] - disc[2], disc[0] + disc[2], disc[1] - disc[2], disc[1] + disc[2]];
}

// A range around the robots that has the patches beside them in it, as far as that leaves room for the robots.
function withPatches(low, high, side) {
  const room = 0.3 * (high - low);
  const edges = data.floor.patches.flatMap((patch) => sidesOf(patch).slice(side === 'x' ? 0 : 2).slice(0, 2));
  const near = edges.map((edge) => Math.min(Math.max(edge, low - room), high + room));
  return [Math.min(low, ...near), Math.max(high, ...near)];
}

function patchShapes([left, right]) {
  const metre = (floor.clientWidth - MARGIN.l - MARGIN.r) / (right - left); // [px]
  return data.floor.patches.map((patch) => {
    const {friction, rectangle, colour} = patch;
    const [x0, x1, y0, y1] = sidesOf(patch);
    const small = (x1 - x0) * metre < PATCH_NAME; // its name stands below it
    return {
      type: rectangle ? 'rect' : 'circle', x0, x1, y0, y1, layer: 'below', fillcolor: colour, opacity: 0.5,
      line: {width: 0.5, color: inks().ink},
      label: {text: `friction ${friction}`, textposition: 'bottom center', yanchor: small ? 'top' : 'bottom', font: {size: 10, color: inks().ink}},
    };
  });
}

function floorLayout() {
  const [x, y] = floorRanges();
  return layout(floor, {
    hovermode: 'closest', dragmode: 'pan', shapes: patchShapes(x),
    xaxis: axis({range: x, title: {text: 'x [m]', standoff: 6}}),
    yaxis: axis({range: y, title: {text: 'y [m]', standoff: 6}, scaleanchor: 'x'}),
  });
}

// Robots on the floor, in metres about the axle midpoint, nose along +x: a dart on an axle with two wheels.
const half = data.floor.half_separation ?? 0.05;
const wheel = data.floor.wheel_radius ?? 0.4 * half;
const DART = [[0.62, 0], [-0.38, 0.34], [-0.2, 0], [-0.38, -0.34]].map(([x, y]) => [x / 0.34 * half, y / 0.34 * half]);
const LENGTH = DART[0][0] - DART[1][0];

function dart() {
  return `M${DART.map((corner) => corner.join(',')).join('L')}z`;
}

function outline() {
  const tyre = (y) => `M${-wheel},${y - wheel / 3}h${2 * wheel}v${2 * wheel / 3}h${-2 * wheel}z`;
  const axle = `M${-wheel / 6},${-half}h${wheel / 3}v${2 * half}h${-wheel / 3}z`;
  return dart() + axle + tyre(half) + tyre(-half);
}

function makeRobots() {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('class', 'overlay');
  const kinds = data.twin ? ['pose', 'twin'] : ['pose'];
  // Twins come first and the root comes last: what comes later lies above.
  const robots = kinds.flatMap((kind) => data.robots.map((robot, place) => {
    const group = document.createElementNS(svg.namespaceURI, 'g');
    const shape = document.createElementNS(svg.namespaceURI, 'path');
    const virtual = data.virtual_root && place === 0;
    group.setAttribute('class', `robot${kind === 'twin' ? ' twin' : ''}${virtual ? ' virtual' : ''}`);
    group.dataset.robot = robot.name;
    group.dataset.kind = kind;
    if (kind === 'pose') group.style.setProperty('--colour', robot.colour);
    shape.setAttribute('d', virtual ? dart() : outline());
    group.append(shape);
    return {kind, place, group};
  }));
  const touches = data.touches.map((touch) => {
    const cross = document.createElementNS(svg.namespaceURI, 'path');
    cross.setAttribute('class', 'touch');
    cross.setAttribute('d', 'M-5,-5L5,5M-5,5L5,-5');
    return {...touch, cross};
  });
  svg.append(...robots.map(({group}) => group).reverse(), ...touches.map(({cross}) => cross));
  floor.append(svg);
  return {svg, robots, touches};
}

function placeRobots({svg, robots, touches}, frame) {
  const [width, height] = [floor.clientWidth - MARGIN.l - MARGIN.r, floor.clientHeight - MARGIN.t - MARGIN.b];
  Object.assign(svg.style, {left: `${MARGIN.l}px`, top: `${MARGIN.t}px`, width: `${width}px`, height: `${height}px`});
  const [[left, right], [bottom, top]] = [floor.layout.xaxis.range, floor.layout.yaxis.range];
  const pixels = width / (right - left);
  const shown = {pose: isShown('pose'), twin: isShown('twin')};
  const larger = Math.max(1, LEAST_ROBOT / (LENGTH * pixels));
  for (const {kind, place, group} of robots) {
    const [x, y, heading] = ['x', 'y', 'h'].map((part) => frames[kind][part][place][frame]);
    const seen = x !== null && shown[kind];
    group.style.display = seen ? '' : 'none';
    if (!seen) continue;
    const size = pixels * larger;
    const [across, down] = [(x - left) * pixels, (top - y) / (top - bottom) * height];
    const turn = heading * 180 / Math.PI;
    group.setAttribute('transform', `translate(${across} ${down}) scale(${size} ${-size}) rotate(${turn})`);
  }
  for (const {time, x, y, cross} of touches) {
    cross.style.display = time <= frames.time[frame] ? '' : 'none';
    cross.setAttribute('transform', `translate(${(x - left) * pixels} ${(top - y) / (top - bottom) * height})`);
  }
  return larger;
}
