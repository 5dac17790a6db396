"""The explanatory drawings: their lengths and directions are right, and their labels readable."""

import functools
import json
import re
import tomllib
from itertools import combinations, pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

from mobility_imu.errors import InputError
from mobility_imu.plots.scooter_equipment import (
    HEIGHT_M,
    LENGTH_M,
    draw_controls,
    draw_measuring_chain,
    draw_scooter,
    draw_static_conditions,
)
from mobility_imu.plots.walker_tilts import (
    AXIS_M,
    OBLIQUE,
    draw_arm_angles,
    draw_chord,
    draw_poses,
    draw_tilts,
    draw_triangles,
    view_of,
)
from mobility_imu.plots.wheelchair_document import (
    FROM_BEHIND,
    FROM_THE_FRONT,
    document_wheel_axes,
    draw_document_frames,
    plot_document_chronogram,
)
from mobility_imu.reproduction.scooter.static_table import (
    SLOPE_RAD,
    STEERING_POSITIONS_RAD,
    THROTTLE_POSITIONS_RAD,
)
from mobility_imu.reproduction.walker.tables import POSES, pose_mount
from mobility_imu.rotations import elementary_rotation
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry, body_specific_force
from mobility_imu.walker.geometry import TILT_DIRECTIONS, WalkerGeometry
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    distance_to_edge,
    imu_height,
    position_four_tilts,
    position_two_tilts,
)
from mobility_imu.wheelchair.geometry import DOCUMENT_TO_CHAIR, WheelchairGeometry, side_sign
from mobility_imu.wheelchair.tasks import Task

ROOT = Path(__file__).resolve().parents[1]
FIGURES = tomllib.loads((ROOT / "mobility_imu/reproduction/figures.toml").read_text())
FOOTPRINT = WalkerGeometry(0.60, 0.52)
PLACE = np.array([0.36, -0.09, 0.62])
CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.317, wheel_radius_right_m=0.317, track_m=0.84
)
TILT_RAD = float(np.deg2rad(30))


def static_conditions():
    return draw_static_conditions(
        SUZUKI_ET4D,
        slope_rad=SLOPE_RAD,
        steering_positions_rad=STEERING_POSITIONS_RAD,
        throttle_positions_rad=THROTTLE_POSITIONS_RAD,
    )


def six_tasks():
    codes = np.repeat([1, 2, 6, 1, 3, 6, 5, 4], 20)
    return plot_document_chronogram(codes, np.linspace(-1, 3, len(codes)))


DRAWINGS = {
    "scooter": lambda: draw_scooter(SUZUKI_ET4D),
    "controls": lambda: draw_controls(SUZUKI_ET4D, throttle_rad=np.deg2rad(40)),
    "chain": draw_measuring_chain,
    "conditions": static_conditions,
    "document": draw_document_frames,
    "chronogram": six_tasks,
    "tilts": lambda: draw_tilts(FOOTPRINT, PLACE, tilt_rad=TILT_RAD),
    "chord": lambda: draw_chord(0.62, np.deg2rad(45)),
    "triangles": lambda: draw_triangles(FOOTPRINT, PLACE),
    "angles": lambda: draw_arm_angles(FOOTPRINT, PLACE),
    "poses": lambda: draw_poses(FOOTPRINT, [pose_mount(pose) for pose in POSES]),
}


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


def lines(figure, gid):
    """Points of every line of that name, (2, n) each, in the drawing's units."""
    found = [np.array(a.get_data(), float) for a in figure.findobj() if a.get_gid() == gid]
    assert found, f"nothing drawn under the name {gid}"
    return found


def vector(figure, gid):
    """From the first to the last point of the one line of that name."""
    (points,) = lines(figure, gid)
    return points[:, -1] - points[:, 0]


def length(figure, gid):
    return float(np.linalg.norm(vector(figure, gid)))


def heading(of):
    return float(np.arctan2(of[1], of[0]))


def shown(figure):
    """Visible texts with their boxes on the screen, px; not the ticks of axes that are off."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    of = matplotlib.text.Text
    off = [
        t
        for ax in figure.axes
        if not ax.axison
        for axis in (ax.xaxis, ax.yaxis)
        for t in axis.findobj(of)
    ]
    hidden = set(map(id, off))
    return [
        (text, of.get_window_extent(text, renderer))
        for text in figure.findobj(of)
        if text.get_visible() and text.get_text().strip() and id(text) not in hidden
    ]


@functools.cache
def drawn(name):
    """Width of a drawing in inches, its page, and text, size in points and box of its letters."""
    figure = DRAWINGS[name]()
    letters = [(text.get_text(), text.get_fontsize(), box) for text, box in shown(figure)]
    return figure.get_figwidth(), figure.bbox.frozen(), letters


class TestReadable:
    @pytest.mark.parametrize("name", DRAWINGS)
    def test_letters_are_9_px_on_a_phone(self, name):
        width, _, letters = drawn(name)
        for text, size, _ in letters:
            on_phone = size / 72 * 360 / width
            assert on_phone >= 9.0, text

    @pytest.mark.parametrize("name", DRAWINGS)
    def test_labels_do_not_overlap_and_lie_on_the_page(self, name):
        _, page, letters = drawn(name)
        for text, _, box in letters:
            assert page.x0 - 2 <= box.x0 and box.x1 <= page.x1 + 2, text
            assert page.y0 - 2 <= box.y0 and box.y1 <= page.y1 + 2, text
        for (one, _, a), (other, _, b) in combinations(letters, 2):
            across = min(a.x1, b.x1) - max(a.x0, b.x0)
            along = min(a.y1, b.y1) - max(a.y0, b.y0)
            assert across < 2 or along < 3, (one, other)


class TestScooter:
    def test_outline_has_the_printed_length_and_height(self):
        figure = draw_scooter(SUZUKI_ET4D)
        corners = [lines(figure, "lever")[0].T]
        for patch in figure.axes[0].patches:
            if isinstance(patch, Polygon):
                corners.append(patch.get_xy())
            elif isinstance(patch, Circle):
                corners.append(np.add(patch.center, patch.radius * np.array([[1, 1], [-1, -1]])))
        low, high = np.vstack(corners).min(axis=0), np.vstack(corners).max(axis=0)
        assert np.allclose(low, [0, 0]) and np.allclose(high, [LENGTH_M, HEIGHT_M])
        assert (LENGTH_M, HEIGHT_M) == (1.195, 0.980)  # section 2.1: 1195 and 980 mm
        assert np.isclose(length(figure, "length"), LENGTH_M)
        assert np.isclose(length(figure, "height"), HEIGHT_M)

    @pytest.mark.parametrize("alpha_deg", [12, 20, 25])
    def test_shaft_leans_back_by_alpha(self, alpha_deg):
        figure = draw_scooter(ScooterGeometry.from_degrees(alpha_deg, 9))
        shaft, vertical = vector(figure, "shaft"), vector(figure, "vertical")
        assert np.isclose(heading(shaft) - heading(vertical), np.deg2rad(alpha_deg))
        assert shaft[0] < 0 < shaft[1]  # forward is to the right: it leans back

    def test_lever_tips_forward_by_the_throttle_angle(self):
        figure = draw_controls(SUZUKI_ET4D, throttle_rad=np.deg2rad(35))
        rest, pushed = vector(figure, "lever rest"), vector(figure, "lever pushed")
        assert np.isclose(heading(rest) - heading(pushed), np.deg2rad(35))
        assert np.isclose(heading(rest) - np.pi / 2, SUZUKI_ET4D.lever_inclination_rad)

    def test_chain_has_no_loose_end(self):
        figure = draw_measuring_chain()
        (ax,) = figure.axes
        boxes = [p.get_bbox() for p in ax.patches if isinstance(p, Rectangle)]
        arrows = [p for p in ax.patches if isinstance(p, FancyArrowPatch)]
        assert len(boxes) == 11 and len(arrows) == 12
        for arrow in arrows:
            (x, top), (same, bottom) = arrow._posA_posB
            assert x == same and top > bottom
            assert any(np.isclose(top, b.y0) and b.x0 < x < b.x1 for b in boxes)
            assert any(np.isclose(bottom, b.y1) and b.x0 < x < b.x1 for b in boxes)

    def test_conditions_are_the_25_of_table_1(self):
        figure = static_conditions()
        steering = np.array([heading(p[:, 1] - p[:, 0]) for p in lines(figure, "steering")])
        throttle = np.array([heading(p[:, 1] - p[:, 0]) for p in lines(figure, "throttle")])
        assert len(steering) == 5 * 2 * 7 and len(throttle) == 5 * 3 * 4
        for fan in steering.reshape(10, 7):  # from above, forward up: left is positive
            assert np.allclose(fan - np.pi / 2, STEERING_POSITIONS_RAD)
        rest = np.pi / 2 + SUZUKI_ET4D.lever_inclination_rad
        for fan in throttle.reshape(15, 4):  # from the right, forward to the right: tips over
            assert np.allclose(rest - fan, THROTTLE_POSITIONS_RAD)
        levers = [heading(p[:, 1] - p[:, 0]) for p in lines(figure, "lever status")]
        assert np.allclose(rest - np.array(levers), np.deg2rad([0, 40]))
        wheels = [heading(p[:, 1] - p[:, 0]) for p in lines(figure, "wheel status")]
        assert np.allclose(wheels, np.deg2rad([0, 50, -50]))

    def test_slopes_are_those_of_the_static_table(self):
        figure = static_conditions()
        slopes = [heading(vector(figure, f"ground {row}")) for row in range(5)]
        # From the right the nose is to the right; from behind the left side is to the left.
        assert np.allclose(slopes, np.deg2rad([0, 5, -5, -5, 5]))
        gravity = np.linalg.norm(body_specific_force(0.0, 0.0))
        forward_up, right_up = gravity * np.sin(slopes[1]), gravity * np.sin(slopes[3])
        assert np.isclose(body_specific_force(SLOPE_RAD, 0.0)[1], forward_up)
        assert np.isclose(body_specific_force(0.0, -SLOPE_RAD)[0], right_up)


class TestDocument:
    def test_change_of_axes_is_a_rotation(self):
        assert np.array_equal(DOCUMENT_TO_CHAIR @ DOCUMENT_TO_CHAIR.T, np.eye(3))
        assert np.isclose(np.linalg.det(DOCUMENT_TO_CHAIR), 1)
        forward, up, right = DOCUMENT_TO_CHAIR.T
        assert forward.tolist() == [1, 0, 0] and up.tolist() == [0, 0, 1]
        assert right.tolist() == [0, -1, 0]
        assert np.allclose(DOCUMENT_TO_CHAIR, elementary_rotation("x", np.pi / 2))
        with pytest.raises(ValueError):
            DOCUMENT_TO_CHAIR[0, 0] = 2.0

    def test_yaw_is_to_the_left_in_both(self):
        assert (DOCUMENT_TO_CHAIR @ [0, 1, 0]).tolist() == [0, 0, 1]

    @pytest.mark.parametrize("side", ["left", "right"])
    def test_wheel_axes_of_the_figure(self, side):
        x, y, z = document_wheel_axes(CHAIR, side).T
        assert np.allclose([x @ y, y @ z, z @ x], 0) and np.allclose(np.cross(x, y), z)
        assert z @ CHAIR.wheel_centre(side) > 0 and z[2] > 0  # outward, and up with the camber
        assert y[2] > 0 and y[1] * side_sign(side) < 0  # up, its top leaning in
        assert np.isclose(abs(z @ CHAIR.axle_direction(side)), 1)

    def test_right_wheel_has_nearly_the_axes_of_the_chair(self):
        upright = WheelchairGeometry.from_degrees(
            0, wheel_radius_left_m=0.317, wheel_radius_right_m=0.317, track_m=0.6
        )
        assert np.allclose(document_wheel_axes(upright, "right"), DOCUMENT_TO_CHAIR)

    @pytest.mark.parametrize(("v", "yaw"), [(1.2, 0.0), (0.0, 0.9), (1.4, -0.7)])
    def test_printed_signs_with_the_axes_of_the_figure(self, v, yaw):
        """(1.17) gives the velocity, (1.18) the yaw rate to the right."""
        spin = {}
        for side in ("left", "right"):
            contact = np.array([0.0, side_sign(side) * CHAIR.track_m / 2, 0.0])
            centre = CHAIR.wheel_centre(side)
            travel = v * np.array([1.0, 0, 0]) + np.cross([0, 0, yaw], centre)
            # Without slip the wheel's lowest point stands still: solve for the spin about Z.
            x, _, z = document_wheel_axes(CHAIR, side).T
            arm = contact - centre
            still = travel + np.cross([0, 0, yaw], arm)
            spin[side] = -(still @ x) / (np.cross(z, arm) @ x)
            assert np.allclose(still + spin[side] * np.cross(z, arm), 0)
        r, d = 0.317, CHAIR.track_m
        assert np.isclose((spin["left"] * r - spin["right"] * r) / 2, v)
        assert np.isclose((spin["left"] * r + spin["right"] * r) / d, -yaw)

    def test_arrows_point_where_the_axes_do(self):
        figure = draw_document_frames(CHAIR)
        right = document_wheel_axes(CHAIR, "right")
        for name, expected in (
            ("printed Y", [0, 1]),
            ("printed Z", [1, 0]),
            ("our z", [0, 1]),
            ("our y", [-1, 0]),
            ("printed wheel Y", FROM_THE_FRONT @ right[:, 1]),
            ("printed wheel Z", FROM_THE_FRONT @ right[:, 2]),
            ("our axle", FROM_THE_FRONT @ CHAIR.axle_direction("right")),
            ("our axle left", FROM_BEHIND @ CHAIR.axle_direction("left")),
            ("our axle right", FROM_BEHIND @ CHAIR.axle_direction("right")),
        ):
            drawn = vector(figure, name)
            assert np.allclose(drawn / np.linalg.norm(drawn), expected), name
        outward = vector(figure, "printed wheel Z")
        assert outward[0] < 0 < outward[1]  # the chair's right is on the left, seen from the front
        assert outward @ vector(figure, "our axle") < 0
        for name in "YZ":
            near = vector(figure, f"printed sensor {name}") @ vector(
                figure, f"printed wheel {name}"
            )
            assert near > 0.95 * length(figure, f"printed sensor {name}") * length(
                figure, f"printed wheel {name}"
            )

    def test_chronogram_covers_every_frame_with_its_task(self):
        codes = np.repeat([1, 2, 6, 1, 3, 6, 5, 4], [5, 9, 7, 1, 8, 7, 6, 4])
        figure = plot_document_chronogram(codes, np.zeros(len(codes)))
        ax = figure.axes[0]
        drawn = np.zeros(len(codes), int)
        for task in Task:
            for band in (a for a in ax.patches if a.get_gid() == task.name):
                first, width = band.get_x(), band.get_width()
                drawn[round(first) : round(first + width)] = task
        assert np.array_equal(drawn, codes)
        assert ax.get_ylim()[0] <= -1 and ax.get_ylim()[1] >= 3.5
        names = [text.get_text() for text in figure.legends[0].get_texts()]
        assert names == [task.title for task in Task]
        looks = {(p.get_facecolor(), p.get_hatch()) for p in figure.legends[0].get_patches()}
        assert len(looks) == 6 and len({hatch for _, hatch in looks}) == 6

    def test_chronogram_refuses_an_unknown_task(self):
        with pytest.raises(InputError):
            plot_document_chronogram([1, 7], [0.0, 0.0])


def edge_distances(place):
    x, y, h = place
    half, long = FOOTPRINT.footprint_width_m / 2, FOOTPRINT.footprint_length_m
    return {
        "front": np.hypot(long - x, h),
        "back": np.hypot(x, h),
        "right": np.hypot(y + half, h),
        "left": np.hypot(half - y, h),
    }


class TestWalker:
    @pytest.mark.parametrize("tilt", TILT_DIRECTIONS)
    def test_tilt_keeps_the_distance_and_goes_its_way(self, tilt):
        figure = draw_tilts(FOOTPRINT, PLACE, tilt_rad=TILT_RAD)
        before, after = vector(figure, f"{tilt} arm before"), vector(figure, f"{tilt} arm after")
        distance = edge_distances(PLACE)[tilt]
        assert np.isclose(np.linalg.norm(before), distance)
        assert np.isclose(np.linalg.norm(after), distance)
        assert np.isclose(abs(heading(before) - heading(after)), TILT_RAD)
        chord = float(np.linalg.norm(after - before))
        assert np.isclose(distance_to_edge(chord, TILT_RAD), distance)
        way = {"front": [1, 0, 0], "back": [-1, 0, 0], "right": [0, -1, 0], "left": [0, 1, 0]}
        assert (after - before) @ (view_of(tilt).screen @ way[tilt]) > 0

    @pytest.mark.parametrize("angle_deg", [20, 45])
    def test_chord_belongs_to_distance_and_angle(self, angle_deg):
        figure = draw_chord(0.62, np.deg2rad(angle_deg))
        assert np.isclose(length(figure, "d before"), 0.62)
        assert np.isclose(length(figure, "d after"), 0.62)
        found = distance_to_edge(length(figure, "l"), np.deg2rad(angle_deg))
        assert np.isclose(found, 0.62)
        assert np.isclose(length(figure, "half"), 0.62 * np.cos(np.deg2rad(angle_deg / 2)))

    @pytest.mark.parametrize("place", [PLACE, np.array([0.2, 0.15, 0.7])])
    def test_triangles_have_the_sides_and_heights_of_14_and_15(self, place):
        figure = draw_triangles(FOOTPRINT, place)
        names = {"front": "d_1", "back": "d_2", "right": "d_3", "left": "d_4"}
        drawn = {tilt: length(figure, name) for tilt, name in names.items()}
        for tilt, distance in edge_distances(place).items():
            assert np.isclose(drawn[tilt], distance)
        assert np.isclose(length(figure, "AB"), FOOTPRINT.footprint_width_m)
        assert np.isclose(length(figure, "AD"), FOOTPRINT.footprint_length_m)
        heights = [length(figure, f"h over {base}") for base in ("AB", "AD")]
        assert np.allclose(heights, imu_height(drawn, FOOTPRINT))
        h = heights[0]
        for name in ("d_2", "d_3", "d_4"):
            leg = length(figure, f"leg of {name}")
            assert np.isclose(leg, np.sqrt(length(figure, name) ** 2 - h**2))
        legs = [length(figure, f"leg of {name}") for name in ("d_2", "d_3", "d_4")]
        assert np.allclose([legs[0], (legs[1] - legs[2]) / 2, h], place)
        assert np.allclose(position_four_tilts(drawn, FOOTPRINT, form="printed"), place)

    @pytest.mark.parametrize("place", [PLACE, np.array([0.2, 0.15, 0.7])])
    def test_angles_give_the_position_by_16_to_19(self, place):
        figure = draw_arm_angles(FOOTPRINT, place)
        arms, gammas = [], []
        for index in (2, 3):
            arm, up = vector(figure, f"d{index}"), vector(figure, f"up{index}")
            velocity, g = vector(figure, f"v{index}"), vector(figure, f"g{index}")
            assert np.isclose(arm @ velocity, 0)  # it starts at right angles to the arm
            beta = abs(heading(velocity) - heading(g))
            gammas.append(abs(heading(arm) - heading(up)))
            assert np.isclose(gammas[-1], np.pi / 2 - beta)
            assert np.isclose(arm_angle([velocity[0], 0, velocity[1]]), gammas[-1])
            arms.append(float(np.linalg.norm(arm)))
        assert np.allclose(position_two_tilts(*arms, *gammas, 0.60), place)
        assert vector(figure, "v2")[0] < 0  # from the right, a tilt to the back goes left
        assert vector(figure, "v3")[0] > 0  # from behind, a tilt to the right goes right
        assert np.isclose(length(figure, "x"), place[0])
        assert np.isclose(length(figure, "y from BC"), place[1] + 0.30)

    def test_poses_show_the_axes_of_table_1(self):
        mounts = [pose_mount(pose) for pose in POSES]
        figure = draw_poses(FOOTPRINT, mounts)
        for k, mount in enumerate(mounts, start=1):
            for name, axis in zip("xyz", np.eye(3), strict=True):
                expected = AXIS_M * OBLIQUE @ mount.rotation_imu_to_body @ axis
                assert np.allclose(vector(figure, f"pose {k} {name}"), expected)
                start = lines(figure, f"pose {k} {name}")[0][:, 0]
                assert np.allclose(start, OBLIQUE @ mount.translation_body_m)


# The table of figures.

PRINTED = {
    "scooter": [
        *("Figure 1a", "Figure 1b", "Figure 2", "Figure 3a", "Figure 3b", "Figure 3c"),
        *(f"Figure {k}" for k in range(4, 10)),
        "Table 1",
    ],
    "wheelchair": ["Figure 1", "Chronogram (section 2.6)", "Table 1", "Table 2"],
    "walker": [
        *("Figure 1", "Figure 2a", "Figure 2b", "Figure 3", "Figure 4", "Figure 5", "Figure 6"),
        *("Figure 7", "Table 1", "Table 2", "Table 3", "Table 4"),
        "Parameter estimation procedure",
    ],
}
ENTRIES = [
    pytest.param(e, id=f"{e['work']}-{e['printed']}-{e['basis']}".replace(" ", "-"))
    for e in FIGURES["figure"]
]


def page_cells(page):
    return json.loads((ROOT / f"{page}.ipynb").read_text())["cells"]


def figures_of(page):
    """Caption of each figure of a page, by its label."""
    found = {}
    for cell in page_cells(page):
        figure = cell["metadata"].get("mystnb", {}).get("figure", {})
        if figure:
            found[figure["name"]] = figure["caption"]
    return found


@pytest.mark.parametrize("work", PRINTED)
def test_no_figure_or_table_of_a_work_is_missing(work):
    listed = list(dict.fromkeys(e["printed"] for e in FIGURES["figure"] if e["work"] == work))
    assert listed == PRINTED[work]


@pytest.mark.parametrize("entry", ENTRIES)
def test_counterpart_exists(entry):
    assert entry["basis"] in FIGURES["bases"]
    if entry["basis"] == "not reproducible":
        assert not entry["labels"] and len(entry["note"]) > 25  # it says why
        return
    assert entry["labels"]
    text = "".join("".join(cell["source"]) for cell in page_cells(entry["page"]))
    for label in entry["labels"]:
        assert label in figures_of(entry["page"]) or f"({label})=" in text


@pytest.mark.parametrize("entry", ENTRIES)
def test_caption_says_what_a_drawing_is_drawn_from(entry):
    words = {
        "drawn": r"[Dd]rawn from .*caption.*(not seen|without its figure)",
        "original": r"compared .*with the original figure",
    }
    if entry["basis"] not in words:
        return
    for label in entry["labels"]:
        assert re.search(words[entry["basis"]], figures_of(entry["page"])[label]), label


def test_page_of_the_table_shows_all_works():
    page = (ROOT / "book/figures.md").read_text()
    assert re.findall(r"\{figure-counterparts\} (\w+)", page) == list(PRINTED)
    assert "book/figures" in (ROOT / "book/_toc.yml").read_text()
    assert "figure_counterparts" in (ROOT / "book/_config.yml").read_text()


def test_drawings_number_in_order():
    """The list under the side view explains the numbers that stand in it."""
    figure = draw_scooter(SUZUKI_ET4D)
    numbers = [t.get_text() for t in figure.axes[0].texts if t.get_text().isdigit()]
    assert sorted(numbers) == sorted([*"12345", *"12345"])
    assert all(int(b) == int(a) + 1 for a, b in pairwise(numbers[-5:]))
