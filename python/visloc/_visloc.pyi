"""Types of visloc. Images are numpy arrays of uint8: (height, width, 3) with red first, or (height, width)."""

from collections.abc import Iterator
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__version__: str

class VislocError(Exception):
    """What was expected and found, where, and what to do."""

@final
class Map:
    """A known map."""

    def __new__(cls, name: str) -> Map:
        """The name of one that is built in (``map_names()``), or a file: dimensions of a field, plan of a building, SVG, DXF, grid.

        :raises VislocError: if it cannot be read or no world can be like this.
        """
    @property
    def name(self) -> str: ...
    def to_toml(self) -> str:
        """The map as text of its file."""

def map_names() -> list[str]:
    """Names of the maps that are built in."""

@final
class Camera:
    """The calibration of a camera. The center of the top-left pixel is (0, 0)."""

    def __new__(
        cls,
        size_px: tuple[int, int],
        focal_px: tuple[float, float],
        center_px: tuple[float, float],
        distortion: list[float] = ...,
        model: str = "radial-tangential",
    ) -> Camera:
        """:param size_px: width and height.
        :param distortion: none; k1, k2, p1, p2 and maybe k3; or k1 to k4 of ``model="kannala-brandt"``.
        """
    @staticmethod
    def load(path: str | PathLike[str]) -> Camera:
        """Reads a calibration of visloc, ROS, Kalibr, OpenCV or a dataset."""
    def to_toml(self) -> str:
        """The text of a file that ``load`` reads."""
    @property
    def size_px(self) -> tuple[int, int]: ...
    @property
    def focal_px(self) -> tuple[float, float]: ...
    @property
    def center_px(self) -> tuple[float, float]: ...
    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (N, 2) of points (N, 3) in the camera's frame; NaN where a point has none."""
    def bearing(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Directions (N, 3) of length 1 in the camera's frame towards pixels (N, 2)."""

@final
class Frame:
    """What a robot senses at a moment."""

    def __new__(
        cls,
        at_s: float,
        image: NDArray[np.uint8],
        camera: Camera,
        *,
        height_m: float | None = None,
        tilt_rad: float = 0.0,
        pan_rad: float = 0.0,
        roll_rad: float = 0.0,
        forward_m: float = 0.0,
        robot_from_camera: NDArray[np.float64] | None = None,
        odometry: tuple[float, float, float] | None = None,
        is_on_ground: bool | None = None,
    ) -> Frame:
        """:param at_s: when the image was taken, seconds.
        :param height_m: of the camera above the ground; with ``tilt_rad`` (down is positive), ``pan_rad`` (to the left),
            ``roll_rad`` and ``forward_m`` (ahead of the robot's middle).
        :param robot_from_camera: in place of these, a 4 x 4 matrix.
        :param odometry: accumulated x, y (meters) and heading (radians), if the robot has it.
        :param is_on_ground: what the feet say, if the robot has sensors there.
        """
    @property
    def at_s(self) -> float: ...
    @property
    def image(self) -> NDArray[np.uint8]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def robot_from_camera(self) -> NDArray[np.float64]: ...
    @property
    def odometry(self) -> tuple[float, float, float] | None: ...
    @property
    def truth(self) -> tuple[float, float, float] | None:
        """Where the robot really was: x, y, heading; for evaluation."""

@final
class Frames(Iterator[Frame]):
    """The frames of a source."""

    def __next__(self) -> Frame: ...
    @property
    def map(self) -> Map | None: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def skipped(self) -> list[str]: ...

def frames(source: str, *, camera: str | PathLike[str] | None = None, seed: int | None = None) -> Frames:
    """Opens everything that a robot senses: a bag of ROS 2 or ROS 1, or a simulation (``sim:robocup``).

    :param camera: a calibration, over what the source itself says.
    :param seed: of a simulation.
    """

@final
class Images(Iterator[tuple[float, NDArray[np.uint8]]]):
    """Stamps, seconds, and gray images of a source."""

    def __next__(self) -> tuple[float, NDArray[np.uint8]]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def truth(self) -> list[tuple[float, NDArray[np.float64]]] | None: ...
    @property
    def warnings(self) -> list[str]: ...

def images(
    source: str,
    *,
    camera: str | PathLike[str] | None = None,
    seed: int | None = None,
    scale: float | None = None,
) -> Images:
    """Opens the images of a camera: a folder, a dataset, a bag, a video (with ffmpeg), a simulation (``sim:room``).

    :param scale: size of the images as a factor.
    """

@final
class Hypothesis:
    """One place where the robot may be."""

    x_m: float
    y_m: float
    yaw_rad: float
    probability: float

@final
class Estimate:
    """Where the robot is, as far as the localizer knows."""

    @property
    def x_m(self) -> float: ...
    @property
    def y_m(self) -> float: ...
    @property
    def yaw_rad(self) -> float: ...
    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) over x, y, heading; meters and radians."""
    @property
    def reliability(self) -> float:
        """0 to 1; above 0.6 the robot is localized."""
    @property
    def reliability_up_to_symmetry(self) -> float: ...
    @property
    def likelihood(self) -> float:
        """Of the last image at the pose, 0 to 1."""
    @property
    def is_localized(self) -> bool: ...
    @property
    def hypotheses(self) -> list[Hypothesis]: ...

@final
class Localizer:
    """Finds and follows a robot on a map."""

    def __new__(
        cls,
        map: Map,
        algorithm: str = "evolutionary",
        *,
        seed: int = 1,
        parameters: str | dict[str, Any] | None = None,
        pipeline: str | dict[str, Any] | None = None,
        start: tuple[float, float, float] | None = None,
        start_spread_m: float = 0.3,
        start_spread_rad: float = 0.2,
    ) -> Localizer:
        """:param algorithm: one of ``algorithms()``.
        :param parameters: of the algorithm (``visloc config show NAME``), as TOML or a dict; what is left out keeps its default.
        :param pipeline: of everything else (``visloc config show pipeline``).
        :param start: x, y, heading near which the robot starts, with standard deviations; without it, anywhere.
        """
    def step(self, frame: Frame) -> Estimate:
        """Takes in a frame; frames come in the order of time. Other threads of Python run meanwhile."""
    @property
    def estimate(self) -> Estimate: ...
    def reset(self) -> None:
        """Forgets where the robot was."""

def algorithms() -> list[tuple[str, str]]:
    """Names of the algorithms and what each does."""

@final
class SlamOutcome:
    """What became of an image."""

    @property
    def state(self) -> str:
        """``starting``, ``tracking``, ``supposed`` (where it may be; the map does not change), ``carried`` (by odometry) or ``lost``."""
    @property
    def world_from_camera(self) -> NDArray[np.float64] | None: ...
    @property
    def map(self) -> int | None:
        """Number of the map that the pose is in; `None` without a pose. Maps are joined later when they meet."""
    @property
    def matches(self) -> tuple[int, int]:
        """Landmarks that were recognized, and those that were looked for."""

@final
class Slam:
    """Follows one camera, and makes a map of what it sees."""

    def __new__(
        cls,
        camera: Camera,
        *,
        preset: str | None = None,
        parameters: str | dict[str, Any] | None = None,
        seed: int = 1,
        threaded: bool = False,
    ) -> Slam:
        """:param preset: parameters by name (``visloc config show slam``).
        :param threaded: map on a thread beside tracking; then runs are not repeatable bit by bit.
        """
    def add_image(self, at_s: float, image: NDArray[np.uint8]) -> SlamOutcome:
        """Takes in an image of the camera's size; images come in the order of time. Other threads of Python run meanwhile."""
    def finish(self) -> None:
        """Waits until everything is mapped and adjusts the maps as a whole: no more images come."""
    def trajectory(self, map: int | None = None) -> list[tuple[float, NDArray[np.float64]]]:
        """Final poses: seconds and ``world_from_camera`` (4, 4), in units of the map.

        :param map: one of ``maps``; without it, of all: poses of different maps have nothing to do with each other.
        """
    @property
    def maps(self) -> list[int]:
        """Numbers of the maps that poses are in, the one with the most poses first. A camera that was lost begins another map."""
    def landmarks(self) -> NDArray[np.float64]:
        """Positions (N, 3), in units of the map that is tracked."""
    def save(self, path: str | PathLike[str]) -> None:
        """Writes the map to a file (``.vmap``). One that was there is kept as ``NAME~``."""
    @property
    def num_keyframes(self) -> int:
        """Of the map that is tracked."""

@final
class VisualMap:
    """A map that SLAM has made."""

    @staticmethod
    def load(path: str | PathLike[str]) -> VisualMap:
        """Reads a file (``.vmap``)."""
    @property
    def num_keyframes(self) -> int: ...
    @property
    def damages(self) -> list[str]:
        """What of the file is damaged."""
    @property
    def is_in_meters(self) -> bool: ...

@final
class CameraEstimate:
    """Where a camera is in a map."""

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """(4, 4), in units of the map."""
    @property
    def covariance(self) -> NDArray[np.float64]:
        """(6, 6), translation first (units of the map, radians), in the frame of the camera."""
    @property
    def reliability(self) -> float:
        """0 to 1; localized from 0.6 on."""
    @property
    def is_localized(self) -> bool: ...
    @property
    def support(self) -> str:
        """What the pose rests on: ``map``; ``motion``, what was seen since the map was; ``odometry``."""

@final
class MapLocalizer:
    """Finds a camera in a map and follows it there. The map stays as it is."""

    def __new__(
        cls,
        map: VisualMap,
        camera: Camera,
        *,
        parameters: str | dict[str, Any] | None = None,
        seed: int = 1,
    ) -> MapLocalizer: ...
    def step(
        self,
        at_s: float,
        image: NDArray[np.uint8],
        *,
        odom_from_camera: NDArray[np.float64] | None = None,
    ) -> CameraEstimate | None:
        """Takes in an image of the camera's size; `None` where nothing is known of the place.

        :param odom_from_camera: (4, 4), meters; carries the pose on in a map in meters where the camera sees nothing.
        """

def find_board(board: str, image: NDArray[np.uint8]) -> tuple[list[int], NDArray[np.float64]]:
    """Numbers and pixels (N, 2) of a board's corners.

    :param board: ``9x6 @ 0.03`` (inner corners, side of a square in meters) or ``aprilgrid 6x6 @ 0.088 : 0.3``.
    """

@final
class Calibration:
    """A calibration and how good it is."""

    camera: Camera
    rms_px: float
    parameters: list[tuple[str, float, float]]
    """Name, value, standard deviation."""
    num_used: int
    dropped: list[str]

def calibrate(board: str, images: list[NDArray[np.uint8]], *, model: str = "radial-tangential") -> Calibration:
    """Calibrates a camera from pictures of a board, all of one size.

    :param model: ``radial-tangential``, ``radial-tangential-4`` (without k3) or ``kannala-brandt``.
    """

def evaluate_robot(
    truth: NDArray[np.float64],
    estimate: NDArray[np.float64],
    reliability: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """Compares poses of a robot, rows of t, x, y, heading (seconds, meters, radians), with the truth."""

def evaluate_camera(
    truth_times: NDArray[np.float64],
    truth_poses: NDArray[np.float64],
    times: NDArray[np.float64],
    poses: NDArray[np.float64],
    *,
    alignment: str = "similarity",
    tolerance_s: float = 0.02,
) -> dict[str, Any]:
    """Absolute error of a camera's poses (N, 4, 4) after alignment (``none``, ``rigid``, ``similarity``), as evo computes it."""
