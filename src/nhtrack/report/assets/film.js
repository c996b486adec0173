// The film shows the time of the plots and has no controls of its own. Where it ends before the run does, it stays at its
// last picture.

const film = document.getElementById('video');
const NEAR = 0.02; // [s] of film, less than a picture lasts: not worth a jump
const DRIFT = 0.2; // [s] by which a film that plays may be off before it is sent to where it ought to be
const RATES = [0.0625, 16]; // at which browsers play
const jump = {due: false}; // whether the plots have moved on since the film was sent somewhere

// Seconds of the robot per second of film; taken from the film's length where nothing else is known.
function filmSpeed() {
  return data.film_speed ?? (duration - frames.time[0]) / film.duration;
}

// Where the film ought to be [s].
function filmTime() {
  return Math.min((frames.time[state.frame] - frames.time[0]) / filmSpeed(), film.duration);
}

function isFilmKnown() {
  return film !== null && film.duration > 0 && filmSpeed() > 0;
}

// Sends the film to the time of the plots; a film that is still on its way is sent again when it has arrived.
function seekFilm() {
  if (!isFilmKnown()) return;
  jump.due = film.seeking;
  if (film.seeking || Math.abs(filmTime() - film.currentTime) < NEAR) return;
  film.currentTime = filmTime();
}

// Lets the film play along where a browser can play that fast; elsewhere it is sent from picture to picture.
function playFilm() {
  if (!isFilmKnown()) return;
  const rate = Number(speed.value) / filmSpeed();
  seekFilm();
  if (rate < RATES[0] || rate > RATES[1]) {
    film.pause();
    return;
  }
  film.playbackRate = rate;
  film.play().catch(() => {}); // one that may not play is sent from picture to picture
}

// Keeps a film to the time of plots that move.
function keepFilm() {
  if (!isFilmKnown()) return;
  if (film.paused || Math.abs(filmTime() - film.currentTime) > DRIFT * film.playbackRate) seekFilm();
}

function haltFilm() {
  film?.pause();
  seekFilm();
}

function listenToFilm() {
  film?.addEventListener('click', () => setPlaying(!state.playing));
  film?.addEventListener('loadedmetadata', seekFilm);
  if (film?.readyState > 0) seekFilm();
  film?.addEventListener('seeked', () => {
    if (jump.due) seekFilm();
  });
}
