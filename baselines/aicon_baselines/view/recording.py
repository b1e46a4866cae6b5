"""An episode as one HTML file that plays in a browser without a server."""

from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.scenes import make_scene
from aicon_baselines.view.server import serve

_PICTURES_PER_SECOND = 10.0


def record_html(episode: LiveEpisode, limit: int | None = None) -> str:
    """Run an episode to its end and return the page, with a bar to play it.

    Args:
        episode: The episode, started.
        limit: Steps after which the recording ends in any case.
    """
    time_step = episode.task.time_step
    stride = max(1, round(1.0 / (_PICTURES_PER_SECOND * time_step)))
    last = episode.task.horizon if limit is None else limit

    server = serve("127.0.0.1", 0)
    try:
        scene = make_scene(server, episode)
        scene.start()
        serializer = server.get_scene_serializer()

        while not episode.ended and episode.steps < last:
            episode.step()
            if episode.steps % stride == 0 or episode.ended:
                _draw(scene)
                serializer.insert_sleep(stride * time_step)
        serializer.insert_sleep(1.0)  # the end rests
        return serializer.as_html()
    finally:
        server.stop()


def _draw(scene: Scene) -> None:
    """Draw a moment; its words stand in the world, because there is no panel."""
    scene.draw()
    scene.draw_words()
