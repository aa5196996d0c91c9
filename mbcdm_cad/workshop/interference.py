"""The interference run: test all pairs of bodies for overlap over the whole travel, at their places by drum angle.

Solids are tested by booleans; a cable is tested as a rod that is slightly thinner than the cable. The run lists the
pairs at each pose and the tests that they need, each test once: pairs with the same relative position at many poses
share one test, and after an edit only the changed pairs are tested. Bodies that move together are tested with the drum
centred. Cables are tested against each other and against their own turns by the distance of their centre lines, because
booleans fail on rods that touch. There is no list of exceptions.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians
from typing import Literal

import numpy as np

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.parts.bill import CABLE, FIXED, Bill, Item, MovingBody, Placement, Vector, cable_item
from mbcdm_cad.routes.curves import CablePath, Stretch
from mbcdm_cad.workshop.pairs import Cables, Clash, Faces, Found, Pair, PartShape, Rod, RodShape, Test, rounded


@dataclass(frozen=True)
class Pose:
    """Items that are not cables, and the paths of all cables, with the drum at ``drum_angle_deg``."""

    drum_angle_deg: float
    bodies: tuple[Item, ...]
    cables: tuple[CablePath, ...]


def scenes(layout: Layout, drum_angles_deg: Iterable[float]) -> dict[float, Pose]:
    """The scenes of a design by drum angle."""
    return {
        angle: Pose(
            angle,
            tuple(item for item in layout.bill(angle).items if not is_cable(item)),
            layout.all_cable_paths(radians(angle)),
        )
        for angle in dict.fromkeys(drum_angles_deg)
    }


def travel_poses(half_travel_deg: float, count: int) -> tuple[float, ...]:
    """Drum angles (deg), evenly over the travel, both ends included, and the centre for odd ``count``."""
    return tuple(float(a) for a in np.linspace(-half_travel_deg, half_travel_deg, count))


def is_longest(path: CablePath, stretch: Stretch, others: Sequence[CablePath]) -> bool:
    """Whether none of the other paths of the same cable has more of it in the stretch."""
    length_mm = path.only(stretch.pieces).length_mm
    return all(length_mm >= other.only(stretch.pieces).length_mm for other in others)


@dataclass(frozen=True)
class MovingGroup:
    """Items that move as one body. It turns by ``ratio`` times the drum's angle about ``axis`` through ``point_mm``.

    ``ratio`` has the sign of the rotation and is 0 for fixed items. ``items`` are the names of its items, sorted.
    """

    name: str
    kind: Literal["fixed", "drum", "passed", "input", "stage"]
    axis: Vector
    point_mm: Vector
    ratio: float
    items: tuple[str, ...]

    def at(self, drum_angle_deg: float) -> Placement:
        """Motion of the body from the centred drum to ``drum_angle_deg``."""
        return Placement.about(self.axis, self.ratio * drum_angle_deg, self.point_mm)


def is_cable(item: Item) -> bool:
    """Whether an item is a cable. A cable has another shape at every angle, so it belongs to no body."""
    return item.name.startswith(CABLE)


def bodies(moving: Sequence[MovingBody], centred: Bill) -> tuple[MovingGroup, ...]:
    """The fixed body, then the moving bodies in their order; ``centred`` is the bill with the drum at 0 deg."""
    members: dict[str, list[str]] = {FIXED: [], **{body.name: [] for body in moving}}
    for item in centred.items:
        if not is_cable(item):
            members[item.group].append(item.name)
    names = {body: tuple(sorted(own)) for body, own in members.items()}
    still = MovingGroup(FIXED, "fixed", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0, names[FIXED])
    turning = (MovingGroup(b.name, b.kind, b.axis, b.origin_mm, b.turns_per_drum, names[b.name]) for b in moving)
    return (still, *turning)


@dataclass(frozen=True)
class Look:
    """One pair of bodies at one pose: the test whose answer applies, and the placement of the answer at this pose."""

    key: str
    kind: str
    names: tuple[str, ...]
    drum_angle_deg: float
    placement: Placement

    def clashes(self, found: Found) -> Iterator[Clash]:
        """The test's answer with the names of the bodies, in the frame of the assembly."""
        for i, j, size, *place in found:
            x, y, z = (float(value) for value in self.placement.apply(np.array(place)))
            first, second, where = self.names[i], self.names[j], (x, y, z)
            if self.kind == "cables":
                yield Clash(first, second, "cables", self.drum_angle_deg, where, overlap_mm=size)
            else:
                kind = "solids" if self.kind == "solids" else "cable and solid"
                yield Clash(first, second, kind, self.drum_angle_deg, where, volume_mm3=size)  # type: ignore[arg-type]


@dataclass
class InterferenceRun:
    """The pairs in the order of the result, and the tests by key."""

    looks: list[Look] = field(default_factory=list)
    tests: dict[str, Test] = field(default_factory=dict)

    def add(self, test: Test, kind: str, names: tuple[str, ...], angle_deg: float, placement: Placement) -> None:
        """Add a test of bodies at one pose; ``placement`` leads from the test's frame to the assembly's."""
        key = test.key
        self.tests.setdefault(key, test)
        self.looks.append(Look(key, kind, names, angle_deg, placement))

    def missing(self, known: Mapping[str, Found]) -> list[str]:
        """Keys of the tests whose answers are not known, the longest tests first."""
        return sorted((key for key in self.tests if key not in known), key=lambda key: -self.tests[key].work)

    def clashes(self, known: Mapping[str, Found]) -> tuple[Clash, ...]:
        """All overlaps, from the answers to all tests."""
        return tuple(clash for look in self.looks for clash in look.clashes(known[look.key]))


def interference_run(
    scenes: Mapping[float, Pose],
    bodies: Mapping[str, PartShape],
    poses_deg: Sequence[float],
    half_travel_deg: float,
    diameter_mm: float,
) -> InterferenceRun:
    """All pairs and tests over ``poses_deg``. ``scenes`` by drum angle: the poses, the centre, both ends.

    ``bodies`` by part; items whose part is not among them are left out. The faces of each body are tested against each
    other too.
    """
    run = InterferenceRun()
    for part, body in bodies.items():
        faces = Faces(part, body)
        run.tests.setdefault(faces.key, faces)
    placed = {
        angle: [(item, bodies[item.part].box_at(item.location)) for item in scene.bodies if item.part in bodies]
        for angle, scene in scenes.items()
    }

    def solids(angle_deg: float, together: bool) -> None:
        there = placed[angle_deg]
        low, high = (np.array([box[k] for _, box in there]).reshape(-1, 3) for k in (0, 1))
        meet = np.all((low[:, None] < high[None, :]) & (low[None, :] < high[:, None]), axis=2)
        for i, j in np.argwhere(np.triu(meet, 1)):
            first, second = there[i][0], there[j][0]
            if (first.group == second.group) == together:
                placement = rounded(first.location.inverse @ second.location)
                pair = Pair(bodies[first.part], bodies[second.part], placement)
                run.add(pair, "solids", (first.name, second.name), angle_deg, first.location)

    def rods(angle_deg: float, path: CablePath, stretch: Stretch, own: bool) -> None:
        rod = RodShape(path.only(stretch.pieces), path.diameter_mm or diameter_mm)
        for item, box in placed[angle_deg]:
            if (item.group == stretch.body) == own and rod.is_near(box):
                test = Rod(rod, bodies[item.part], rounded(item.location))
                names = (cable_item(path.cable.name), item.name)
                run.add(test, "cable and solid", names, angle_deg, Placement.identity())

    solids(0.0, together=True)
    ends = (-half_travel_deg, half_travel_deg)
    for end in ends:
        for k, path in enumerate(scenes[end].cables):
            for stretch in path.stretches:
                # A cable is tested against the body that carries it at the pose at which most of the cable lies on it.
                if stretch.body is not None and is_longest(path, stretch, [scenes[other].cables[k] for other in ends]):
                    rods(end, path, stretch, own=True)
    for angle in poses_deg:
        solids(angle, together=False)
        paths = scenes[angle].cables
        names = tuple(cable_item(path.cable.name) for path in paths)
        run.add(Cables(paths, diameter_mm), "cables", names, angle, Placement.identity())
        for path in paths:
            for stretch in path.stretches:
                rods(angle, path, stretch, own=False)
    return run


def answers(run: InterferenceRun, known: Mapping[str, Found], jobs: int) -> dict[str, Found]:
    """Answers to all tests of ``run``: those in ``known``, and the others computed; the same for any ``jobs``."""
    missing = run.missing(known)
    worked_out = fork_map(lambda key: run.tests[key].test(), missing, jobs)
    return {**{key: known[key] for key in run.tests if key in known}, **dict(zip(missing, worked_out, strict=True))}
