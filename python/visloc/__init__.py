"""Where is the camera? Localization with one ordinary camera: on known maps, and SLAM without a map.

On a known map::

    import visloc

    frames = visloc.frames("recording.mcap")
    localizer = visloc.Localizer(visloc.Map("robocup-spl-2010"))
    for frame in frames:
        estimate = localizer.step(frame)
        if estimate.is_localized:
            print(frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad)

Without a map::

    slam = visloc.Slam(visloc.Camera.load("camera.toml"))
    for at_s, image in my_images:              # numpy arrays, as OpenCV has them: gray, or color with red first
        outcome = slam.add_image(at_s, image)
    slam.save("room.vmap")

In a map that was made before::

    localizer = visloc.MapLocalizer(visloc.VisualMap.load("room.vmap"), camera)
    estimate = localizer.step(at_s, image)     # None where nothing is known of the place

Transforms are 4 x 4 matrices named by their frames: ``world_from_camera`` takes points of the camera to the world. The robot looks
along x, y is to its left, z up; a camera looks along z, x is to its right, y down. Lengths are in meters (SLAM: in units of the map),
angles in radians. The same seed and the same images give the same bits, and those of the program ``visloc``; but images with stamps since
1970, which seconds as a float hold to a quarter of a microsecond only, give other last bits in SLAM than in the program.
"""

from ._visloc import (
    Calibration,
    Camera,
    CameraEstimate,
    Estimate,
    Frame,
    Frames,
    Hypothesis,
    Images,
    Localizer,
    Map,
    MapLocalizer,
    Slam,
    SlamOutcome,
    VislocError,
    VisualMap,
    __version__,
    algorithms,
    calibrate,
    evaluate_camera,
    evaluate_robot,
    find_board,
    frames,
    images,
    map_names,
)

__all__ = [
    "Calibration",
    "Camera",
    "CameraEstimate",
    "Estimate",
    "Frame",
    "Frames",
    "Hypothesis",
    "Images",
    "Localizer",
    "Map",
    "MapLocalizer",
    "Slam",
    "SlamOutcome",
    "VislocError",
    "VisualMap",
    "algorithms",
    "calibrate",
    "evaluate_camera",
    "evaluate_robot",
    "find_board",
    "frames",
    "images",
    "map_names",
]
