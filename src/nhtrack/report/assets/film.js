// The film and the plots show one time: whichever of them moves takes the other along. Where the film ends before the
// run does, it stays at its last picture.

const film = document.getElementById('video');
const NEAR = 0.02; // [s] of film, less than a picture lasts: not worth a jump
const jump = {to: 0, due: false}; // where the plots have sent the film [s], and whether they have moved on since

// Seconds of the robot per second of film; taken from the film's length where nothing else is known.
function filmSpeed() {
  return data.film_speed ?? (duration - frames.time[0]) / film.duration;
}

// Sends the film to the time of the plots; a film that is still on its way is sent again when it has arrived.
function seekFilm() {
  if (!film || !(film.duration > 0 && filmSpeed() > 0)) return;
  jump.due = film.seeking;
  if (film.seeking) return;
  const wanted = Math.min((frames.time[state.frame] - frames.time[0]) / filmSpeed(), film.duration);
  if (Math.abs(wanted - film.currentTime) < NEAR) return;
  jump.to = wanted;
  film.currentTime = wanted;
}

function followFilm() {
  if (!(filmSpeed() > 0)) return;
  show(frameAt(frames.time[0] + film.currentTime * filmSpeed() + 1e-6));
}

// Follows a film that plays, picture by picture.
function keepUp() {
  if (!film.seeking) followFilm();
  if (!film.paused) requestAnimationFrame(keepUp);
}

function listenToFilm() {
  film?.addEventListener('play', () => {
    setPlaying(false);
    requestAnimationFrame(keepUp);
  });
  film?.addEventListener('seeking', () => {
    if (Math.abs(film.currentTime - jump.to) > NEAR) {
      jump.to = film.currentTime;
      followFilm();
    }
  });
  film?.addEventListener('seeked', () => {
    if (jump.due) seekFilm();
  });
  film?.addEventListener('loadedmetadata', seekFilm);
}
