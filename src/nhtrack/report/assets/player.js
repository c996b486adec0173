// One time for all plots, and what of them is shown.

const slider = document.getElementById('time');
const play = document.getElementById('play');
const clock = document.getElementById('clock');
const speed = document.getElementById('speed');
const scale = document.getElementById('scale');
const cells = [...document.querySelectorAll('.readouts tbody tr')].map((row) => [...row.querySelectorAll('td')]);
const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const LONGEST = 20; // [s] that a long run takes to play, if a speed of the list lets it

// A page opens at the end of its run, where the whole of it is to be seen.
const state = {frame: frames.time.length - 1, playing: false, since: 0, from: 0, ready: false, robots: null};

// Time ---------------------------------------------------------------------------------------------------------------

function show(frame) {
  state.frame = Math.min(Math.max(frame, 0), frames.time.length - 1);
  const time = frames.time[state.frame];
  slider.value = state.frame;
  clock.textContent = `${time.toFixed(2)} / ${duration.toFixed(1)} s`;
  slider.setAttribute('aria-valuetext', `${time.toFixed(2)} seconds`);
  fillReadouts();
  moveTrails();
  layOver();
}

function fillReadouts() {
  cells.forEach((row, place) => row.forEach((cell, column) => {
    const value = frames.readouts[column].values[place][state.frame];
    cell.textContent = value === null ? '-' : short(value);
  }));
}

function short(value) {
  const size = Math.abs(value);
  const digits = size !== 0 && (size < 1e-3 || size >= 1e5) ? size.toExponential(1) : Number(size.toPrecision(3)).toString();
  return value < 0 ? `−${digits}` : digits;
}

// Puts robots and cursors where the current time and the plots' axes want them.
function layOver() {
  if (state.robots) {
    const larger = placeRobots(state.robots, state.frame);
    drawTrails();
    scale.textContent = larger < 1.05 ? 'Robots are drawn to scale.'
      : `Robots are drawn ${larger.toPrecision(2)} times as large as they are.`;
  }
  panels.filter((panel) => panel.cursor).forEach((panel) => placeCursor(panel, frames.time[state.frame]));
}

// The last frame at or before a time.
function frameAt(time) {
  let [low, high] = [0, frames.time.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (frames.time[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

function setPlaying(playing) {
  state.playing = playing;
  play.classList.toggle('running', playing);
  play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  if (!playing) {
    haltFilm();
    return;
  }
  if (state.frame === frames.time.length - 1) show(0);
  restartClock();
  requestAnimationFrame(tick);
}

function restartClock() {
  state.since = performance.now();
  state.from = frames.time[state.frame];
  if (state.playing) playFilm();
}

function tick(now) {
  if (!state.playing) return;
  show(frameAt(state.from + Math.max(0, now - state.since) / 1000 * Number(speed.value)));
  keepFilm();
  if (state.frame === frames.time.length - 1) setPlaying(false);
  else requestAnimationFrame(tick);
}

function goTo(frame) {
  show(frame);
  restartClock();
  seekFilm();
}

// Keys of elements that have a use for them themselves are left to them, and so are shortcuts of the browser.
function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.closest('input, select, video, .scroll, .readouts')) {
    if (event.target !== slider || event.key !== ' ') return;
  }
  if (event.key === ' ' && event.target.closest('button, summary, a')) return;
  const step = event.shiftKey ? 10 : 1;
  const actions = {
    ' ': () => setPlaying(!state.playing),
    ArrowLeft: () => goTo(state.frame - step),
    ArrowRight: () => goTo(state.frame + step),
    Home: () => goTo(0),
    End: () => goTo(frames.time.length - 1),
  };
  if (!(event.key in actions)) return;
  event.preventDefault();
  actions[event.key]();
}

// What is shown ------------------------------------------------------------------------------------------------------

function showTrajectories() {
  Plotly.restyle(floor, {visible: floor.data.map(({meta}) => isShown(meta))});
  layOver();
}

function showAxes() {
  panels.filter(({decades, knee}) => decades || knee).forEach(drawPanel);
}

function drawPanel(panel) {
  return Plotly.react(panel.div, panelTraces(panel), panelLayout(panel), PANEL_CONFIG).then(() => placeNames(panel));
}

// Draws every plot anew, in the colours and the size of now.
function redraw() {
  if (!state.ready) return;
  Plotly.react(floor, floorTraces(), floorLayout(), CONFIG);
  floor.classList.remove('moving');
  panels.forEach(drawPanel);
  layOver();
}

// Zooming one panel zooms all of them.
function followZoom(source) {
  source.div.on('plotly_relayout', (change) => {
    placeNames(source);
    if (!Object.keys(change).some((key) => key.startsWith('xaxis.')) || change['xaxis.range'] !== undefined) return;
    const whole = change['xaxis.autorange'];
    const range = whole ? WHOLE : [change['xaxis.range[0]'], change['xaxis.range[1]']];
    // `xaxis.range` as a whole is what only this function sets: what it sets off is not followed again.
    for (const panel of panels) Plotly.relayout(panel.div, {'xaxis.range': [...range]}).then(() => {
      placeNames(panel);
      layOver();
    });
  });
  source.div.on('plotly_click', ({points}) => goTo(frameAt(points[0].x)));
}

// To work ------------------------------------------------------------------------------------------------------------

async function draw() {
  await Plotly.newPlot(floor, floorTraces(), floorLayout(), CONFIG);
  state.robots = makeRobots();
  floor.on('plotly_relayout', layOver);
  floor.on('plotly_relayouting', layOver);
  show(state.frame);
  makeTrails(); // from now on the paths move
  mark('firstPlot');
  for (const panel of panels) {
    await pause();
    await Plotly.newPlot(panel.div, panelTraces(panel), panelLayout(panel), PANEL_CONFIG);
    panel.names = makeNames(panel);
    placeNames(panel);
    panel.cursor = makeCursor(panel.div);
    followZoom(panel);
    placeCursor(panel, frames.time[state.frame]);
  }
  state.ready = true;
  mark('ready');
}

function listen() {
  slider.addEventListener('input', () => goTo(Number(slider.value)));
  play.addEventListener('click', () => setPlaying(!state.playing));
  speed.addEventListener('change', restartClock);
  document.addEventListener('keydown', onKey);
  document.getElementById('shown')?.addEventListener('change', showTrajectories);
  document.getElementById('axis')?.addEventListener('change', showAxes);
  listenToFilm();
  watchLook(redraw);
}

const round = SPEEDS.find((factor) => factor >= 1 && duration / factor <= LONGEST) ?? SPEEDS.at(-1);
const usual = data.film_speed ? Number(data.film_speed.toPrecision(3)) : round; // that of the film, if there is one
const speeds = [...new Set([...SPEEDS, usual])].sort((one, other) => one - other);
speed.append(...speeds.map((factor) => new Option(`${factor}×`, factor, factor === usual, factor === usual)));
listen();
draw();
