"""An episode as one HTML file that plays in a browser without a server."""

from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.opening import MakeScene, make_scene
from aicon_baselines.view.server import serve

_PICTURES_PER_SECOND = 10.0
_END = 1.5  # s that the last picture stands


def record_html(episode: LiveEpisode, duration: float, scene: MakeScene = make_scene) -> str:
    """Run an episode and return the page, with a bar to play it.

    Args:
        episode: The episode, started.
        duration: Time after which the recording ends in any case, s.
        scene: What draws the world.
    """
    stride = max(1, round(1.0 / (_PICTURES_PER_SECOND * episode.time_step)))
    server = serve("127.0.0.1", 0)
    try:
        world = scene(server, episode)

        # Begun before anything is drawn: what it finds, it would keep as it is at the end.
        recorder = server.get_scene_serializer()
        world.start()
        while not episode.ended and episode.time < duration:
            for _ in range(stride):
                episode.step()
            recorder.insert_sleep(stride * episode.time_step)
            world.draw()
            world.write(f"{episode.time:.1f} s  {world.headline()}")

        recorder.insert_sleep(_END)
        return recorder.as_html()
    finally:
        server.stop()
