"""The description of the Panda (URDF) that comes with `example-robot-data`."""

import importlib.metadata
from pathlib import Path
from xml.etree import ElementTree


def load_arm() -> str:
    """Return the description of the arm without hand and pictures, with its meshes found.

    Raises:
        ModuleNotFoundError: If `example-robot-data` is missing, or is another version.
    """
    folder = _find_folder()
    root = ElementTree.parse(folder / "urdf" / "panda.urdf").getroot()

    for link in root.findall("link"):
        _remove_pictures(link)
        _strip_mesh_folders(link)
    _remove_hand(root)
    _add_compiler_options(root, folder / "meshes" / "collision")

    return ElementTree.tostring(root, encoding="unicode")


def load_collision_model() -> ElementTree.Element:
    """Return the description whose links are spheres and cylinders.

    Raises:
        ModuleNotFoundError: If `example-robot-data` is missing, or is another version.
    """
    return ElementTree.parse(_find_folder() / "urdf" / "panda_collision.urdf").getroot()


def _find_folder() -> Path:
    """Return the folder of the Panda's files, `urdf` and `meshes`."""
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError as error:
        raise ModuleNotFoundError(
            "the description of the Panda is missing; "
            "it comes with: pip install 'aicon-torch[panda]'"
        ) from error

    # Its files lie around panda.urdf, wherever the package is installed.
    for file in files:
        if file.name == "panda.urdf":
            return Path(str(file.locate())).resolve().parents[1]

    raise ModuleNotFoundError("example-robot-data has no panda.urdf; expected version 6")


def _remove_pictures(link: ElementTree.Element) -> None:
    """Keep only the collision meshes, which the pictures show too."""
    for visual in link.findall("visual"):
        link.remove(visual)


def _strip_mesh_folders(link: ElementTree.Element) -> None:
    """Reduce the names of meshes to those of files; `meshdir` names their folder."""
    for mesh in link.iter("mesh"):
        path = str(mesh.get("filename"))
        mesh.set("filename", path.rsplit("/", 1)[-1])


def _remove_hand(root: ElementTree.Element) -> None:
    """Remove the links and joints of hand and fingers: the stick is in their place."""
    for element in [*root.findall("link"), *root.findall("joint")]:
        name = str(element.get("name"))
        if "hand" in name or "finger" in name:
            root.remove(element)


def _add_compiler_options(root: ElementTree.Element, mesh_folder: Path) -> None:
    """Tell MuJoCo how to read the description."""
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(
        options,
        "compiler",
        meshdir=str(mesh_folder),
        fusestatic="false",  # the flange stays a body
        discardvisual="false",  # true would drop what does not collide
    )
