"""Makes a film of a run; nothing is simulated again."""

import nhtrack

run = nhtrack.run("tour/hello", duration=4)
film = nhtrack.render(run, "hello.mp4", camera="chase", size=(320, 240), speed=4, quality="draft", processes=1)
print(film.path, film.path.stat().st_size > 10_000)
