"""Binary logs written by their own libraries, read and drafted: the same run as from a table of text."""

import builtins
import importlib
import json
from collections.abc import Callable
from pathlib import Path

import h5py
import nptdms
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import yaml
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.io import savemat

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.roles import Expected

RATIO, BEGUN_NS = 8.0, 1_700_000_000_123_456_789
TIME = np.arange(2000) * 0.01
OUTPUT = 0.5 * np.sin(2.0 * np.pi * TIME / 5.0)
INPUT = RATIO * OUTPUT
# The output's messages are sent less often and between those of the motor.
LATER = TIME[:-2:2] + 0.004
SEEN = 0.5 * np.sin(2.0 * np.pi * LATER / 5.0)
ROS2, ROS1 = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS1_NOETIC)
OWN = "bench_msgs/msg/Shaft"
ROS2.register(get_types_from_msg("std_msgs/Header header\nfloat64 angle\nfloat64[3] phase_currents\nbool homed", OWN))


def joints(store: object, time_s: float, angle: float) -> object:
    """A message of ROS with the angle of the motor between two other joints; its stamp is 3 ms before the log's."""
    types = store.types  # type: ignore[attr-defined]
    stamp_ns = BEGUN_NS + round((time_s - 0.003) * 1e9)
    stamp = types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    first = [0] if store is ROS1 else []
    header = types["std_msgs/msg/Header"](*first, stamp, "base")
    values = np.array([0.0, angle, 0.0])
    names = ["cover", "motor", "spare"]
    return types["sensor_msgs/msg/JointState"](header, names, values, np.gradient(values), np.empty(0))


def shaft(time_s: float, angle: float) -> object:
    stamp_ns = BEGUN_NS + round((time_s - 0.003) * 1e9)
    stamp = ROS2.types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    header = ROS2.types["std_msgs/msg/Header"](stamp, "drum")
    return ROS2.types[OWN](header, angle, np.zeros(3), True)


def ns(time_s: float) -> int:
    return BEGUN_NS + round(time_s * 1e9)


def bag_of_ros_1(folder: Path) -> Path:
    with Bag1(folder / "run.bag") as bag:
        kind = "sensor_msgs/msg/JointState"
        motor = bag.add_connection("/joint_states", kind, typestore=ROS1)
        drum = bag.add_connection("/drum_encoder", "std_msgs/msg/Float64", typestore=ROS1)
        for t, angle in zip(TIME, INPUT, strict=True):
            bag.write(motor, ns(t), ROS1.serialize_ros1(joints(ROS1, t, angle), kind))
        for t, angle in zip(LATER, SEEN, strict=True):
            message = ROS1.types["std_msgs/msg/Float64"](angle)
            bag.write(drum, ns(t), ROS1.serialize_ros1(message, "std_msgs/msg/Float64"))
    return folder / "run.bag"


def bag_of_ros_2(folder: Path, storage: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    with Bag2(folder / "run_bag", version=9, storage_plugin=storage) as bag:
        kind = "sensor_msgs/msg/JointState"
        motor = bag.add_connection("/joint_states", kind, typestore=ROS2)
        drum = bag.add_connection("/drum", OWN, typestore=ROS2)
        for t, angle in zip(TIME, INPUT, strict=True):
            bag.write(motor, ns(t), ROS2.serialize_cdr(joints(ROS2, t, angle), kind))
        for t, angle in zip(LATER, SEEN, strict=True):
            bag.write(drum, ns(t), ROS2.serialize_cdr(shaft(t, angle), OWN))
    return folder / "run_bag"


def mcap_of_ros_2(folder: Path) -> Path:
    kind = "sensor_msgs/msg/JointState"
    with open(folder / "run.mcap", "wb") as file:
        log = McapWriter(file)
        log.start(profile="ros2")
        for topic, name, rows, angles in (("/joint_states", kind, TIME, INPUT), ("/drum", OWN, LATER, SEEN)):
            text = ROS2.generate_msgdef(name, ros_version=2)[0].encode()
            channel = log.register_channel(topic, "cdr", log.register_schema(name, "ros2msg", text))
            for t, angle in zip(rows, angles, strict=True):
                message = joints(ROS2, t, angle) if name == kind else shaft(t, angle)
                log.add_message(channel, ns(t), bytes(ROS2.serialize_cdr(message, name)), ns(t))
        log.finish()
    return folder / "run.mcap"


def mcap_of_json(folder: Path) -> Path:
    with open(folder / "run.mcap", "wb") as file:
        log = McapWriter(file)
        log.start()
        for topic, rows, angles in (("/motor", TIME, INPUT), ("/joint", LATER, SEEN)):
            channel = log.register_channel(topic, "json", log.register_schema("Angle", "jsonschema", b"{}"))
            for t, angle in zip(rows, angles, strict=True):
                said = {"angle": float(angle), "name": topic, "raw": {"speed": 0.0}}
                log.add_message(channel, ns(t), json.dumps(said).encode(), ns(t))
        log.finish()
    return folder / "run.mcap"


def parquet(folder: Path) -> Path:
    stamps = (BEGUN_NS + np.round(TIME * 1e9).astype(np.int64)).astype("datetime64[ns]")
    angle = pyarrow.field("joint_angle", pyarrow.float64(), metadata={"unit": "deg"})
    fields = [pyarrow.field("time", pyarrow.timestamp("ns")), pyarrow.field("motor_angle", pyarrow.float64()), angle]
    columns = [pyarrow.array(stamps), pyarrow.array(INPUT), pyarrow.array(np.degrees(OUTPUT))]
    arrays = [*columns, pyarrow.array(["bench"] * TIME.size)]
    schema = pyarrow.schema([*fields, pyarrow.field("place", pyarrow.string())])
    pyarrow.parquet.write_table(pyarrow.table(arrays, schema=schema), folder / "run.parquet")
    return folder / "run.parquet"


def matlab(folder: Path) -> Path:
    bench = {"t": TIME, "motor_pos": INPUT, "joint_pos": OUTPUT, "note": "first run", "rate_Hz": 100.0}
    savemat(folder / "run.mat", {"bench": bench})
    return folder / "run.mat"


def dspace(folder: Path) -> Path:
    """ControlDesk writes structures X and Y with a name and the data of each signal."""
    names, data = ["motor_pos", "joint_pos", "motor_current"], [INPUT, OUTPUT, np.cos(TIME)]
    signals = np.array([{"Name": n, "Data": d} for n, d in zip(names, data, strict=True)], dtype=object)
    savemat(folder / "rec1.mat", {"rec1": {"X": {"Name": "time", "Data": TIME}, "Y": signals}})
    return folder / "rec1.mat"


def matlab_7_3(folder: Path) -> Path:
    """MATLAB's files of version 7.3 are HDF5 with 512 bytes of text before it, and rows for columns."""
    with h5py.File(folder / "run.mat", "w", userblock_size=512) as file:
        for name, row in (("t", TIME), ("motor_pos", INPUT), ("joint_pos", OUTPUT)):
            file.create_dataset(name, data=row[None])
    with open(folder / "run.mat", "r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))
    return folder / "run.mat"


def hdf5(folder: Path) -> Path:
    with h5py.File(folder / "run.h5", "w") as file:
        group = file.create_group("bench")
        for name, row in (("time", TIME), ("motor_pos", INPUT), ("joint_pos", np.degrees(OUTPUT))):
            group.create_dataset(name, data=row).attrs["units"] = {"time": "s", "motor_pos": "rad"}.get(name, "deg")
        file.create_dataset("picture", data=np.zeros((100, 100)))
    return folder / "run.h5"


def tdms(folder: Path) -> Path:
    """Waveforms: the time follows from begin and step of each channel; the joint has half the rate."""
    begin = np.datetime64("2026-03-01T12:00:00.000000")
    with nptdms.TdmsWriter(folder / "run.tdms") as file:
        for name, row, step, late in (("motor", INPUT, 0.01, 0), ("joint", SEEN, 0.02, 4000)):
            said = {"wf_increment": step, "wf_start_offset": 0.0, "wf_start_time": begin + np.timedelta64(late, "us")}
            file.write_segment([nptdms.ChannelObject("angles", name, row, {**said, "unit_string": "rad"})])
    return folder / "run.tdms"


WRITERS: list[Callable[[Path], Path]] = [
    bag_of_ros_1,
    bag_of_ros_2,
    mcap_of_ros_2,
    mcap_of_json,
    parquet,
    matlab,
    dspace,
    matlab_7_3,
    hdf5,
    tdms,
]


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
def test_a_log_is_drafted_and_read_as_it_was_written(write: Callable[[Path], Path], tmp_path: Path) -> None:
    draft = draft_text(write(tmp_path), Expected.of_ratio(RATIO))
    columns = yaml.safe_load(draft)["columns"]
    assert "motor" in str(columns["input"]["column"]), draft
    assert any(word in str(columns["output"]["column"]) for word in ("joint_", "/joint", "drum")), draft
    (tmp_path / "run.yaml").write_text(draft)
    run = load_measurement(tmp_path / "run.yaml")
    assert run.time_s.size >= 980
    assert np.ptp(run.time_s) == pytest.approx(TIME[-1], abs=0.05)
    miss = np.abs(run.input_rad[0] - RATIO * run.output_rad).max()
    # Between two samples of the motor the line is off by a share of its curve.
    assert miss < 1e-4, f"input and output differ by {miss} rad\n{draft}"


def test_a_bag_of_ros_2_in_mcap_and_its_file_alone_are_read(tmp_path: Path) -> None:
    folder = bag_of_ros_2(tmp_path, StoragePlugin.MCAP)
    one = draft_text(folder, Expected.of_ratio(RATIO)).split("\n", 2)[2]
    other = draft_text(next(folder.glob("*.mcap")), Expected.of_ratio(RATIO)).split("\n", 2)[2]
    assert one == other


def test_the_time_of_the_header_or_that_of_the_log(tmp_path: Path) -> None:
    mcap_of_ros_2(tmp_path)
    text = (
        "data: run.mcap\nratio: 8\ncolumns:\n  time: {column: header_stamp, unit: s}\n"
        "  input: {column: /joint_states/motor/position, unit: rad}\n  output: {column: /drum/angle, unit: rad}\n"
    )
    (tmp_path / "run.yaml").write_text(text)
    stamped = load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text(text.replace("header_stamp", "log_time"))
    logged = load_measurement(tmp_path / "run.yaml")
    assert np.allclose(stamped.time_s, logged.time_s, atol=1e-9)
    assert np.allclose(stamped.input_rad, logged.input_rad, atol=1e-9)
    assert stamped.time_s[0] == pytest.approx(LATER[0], abs=1e-9)
    (tmp_path / "run.yaml").write_text(text.replace("/drum/angle", "/drum/angel"))
    with pytest.raises(InputError, match=r"no such column in run.mcap.*did you mean '?/drum/angle"):
        load_measurement(tmp_path / "run.yaml")


def test_what_does_not_belong_together_is_told(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"t": TIME, "motor": INPUT, "joint": SEEN})
    text = (
        "data: run.mat\nratio: 8\ncolumns:\n  time: {column: t, unit: s}\n"
        "  input: {column: motor, unit: rad}\n  output: {column: joint, unit: rad}\n"
    )
    (tmp_path / "run.yaml").write_text(text)
    with pytest.raises(InputError, match="columns of different lengths: t 2000, motor 2000, joint 999"):
        load_measurement(tmp_path / "run.yaml")
    savemat(tmp_path / "run.mat", {"t": TIME, "motor": INPUT, "joint": np.where(TIME == 5.0, np.nan, OUTPUT)})
    with pytest.raises(InputError, match=r"run.mat:501: no finite number in joint"):
        load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text("broken_rows: skip\n" + text)
    assert load_measurement(tmp_path / "run.yaml").time_s.size == TIME.size - 1


@pytest.mark.parametrize(
    ("first", "words"),
    [
        (b"\x89HDF\r\n\x1a\n", "cannot be read as an HDF5 file"),
        (b"MATLAB 5.0 MAT-file", "cannot be read as a file of MATLAB"),
        (b"PAR1\x15", "cannot be read as a Parquet file"),
        (b"TDSm\x0e", "cannot be read as a TDMS file|without columns"),
        (b"\x89MCAP0\r\n", "cannot be read as an MCAP log"),
        (b"#ROSBAG V2.0\n", "cannot be read as a bag of ROS 1"),
        (b"SQLite format 3\x00", "cannot be read as a bag of ROS 2"),
    ],
)
def test_a_damaged_log_is_told_by_its_kind(first: bytes, words: str, tmp_path: Path) -> None:
    path = tmp_path / ("run.bag" if b"ROSBAG" in first else "run.db3")
    path.write_bytes(first + b"\x00" * 400)
    with pytest.raises(InputError, match=words):
        draft_text(path, Expected.of_ratio(RATIO))


def test_without_its_library_the_command_that_installs_it_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = parquet(tmp_path)

    def absent(name: str, package: str | None = None) -> object:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name.split(".")[0])

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(InputError, match=r"Parquet file; the package pyarrow .*pip install 'mbcdm-cad\[logs\]'"):
        draft_text(path, Expected.of_ratio(RATIO))


def test_a_table_of_text_needs_none_of_the_libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.savetxt(tmp_path / "run.csv", np.column_stack([TIME, INPUT, OUTPUT]), delimiter=",")
    real = builtins.__import__

    def told(name: str, *others: object, **more: object) -> object:
        assert name.split(".")[0] not in ("h5py", "mcap", "nptdms", "pyarrow", "rosbags"), name
        return real(name, *others, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", told)
    assert "column: 3" in draft_text(tmp_path / "run.csv", Expected.of_ratio(RATIO))
