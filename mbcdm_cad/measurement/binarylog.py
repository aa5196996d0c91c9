"""Logs that are no tables: MCAP, bags of ROS 1 and 2, Parquet, MATLAB's files, TDMS, HDF5, by their own libraries, and
JSON lines.

The libraries are those of the extra ``mbcdm-cad[logs]``; each is imported where a file of its kind is read. What a file
holds becomes columns by name: ``/joint_states/position[shoulder]`` of a message, ``group/channel`` of TDMS,
``out/motor/Data`` of a structure of MATLAB. Logs of messages, and waveforms of TDMS, have two names more for the time:
``log_time``, at which a message was recorded or a sample taken, and ``header_stamp``, which the message itself carries.
Every quantity is then interpolated from its own times onto those of the output.
"""

import dataclasses
import importlib
import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.datafile import Channel, DataTable, aligned, left_out
from mbcdm_cad.measurement.logformat import Format, wrong
from mbcdm_cad.routes import Floats

# Names of the times of messages and waveforms, in a place that no quantity of a log has.
LOG_TIME, HEADER_STAMP = "log_time", "header_stamp"
EXTRA = "pip install 'mbcdm-cad[logs]', or export the data as CSV"
# Fewest figures of a column, and most of an array in one message: a longer one is a picture or a scan.
FEWEST, LONGEST_ARRAY = 2, 64
# Share of the samples of the fullest channel from which a draft looks at a channel.
LEAST_OF_FULLEST = 0.05
NS_IN_S = 1e9


@dataclasses.dataclass(frozen=True, eq=False)
class Series:
    """One column: its figures, the unit that the file states, and its own times where it has some."""

    name: str
    values: Floats
    unit: str = ""
    log_s: Floats | None = None
    stamp_s: Floats | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class BinaryLog:
    """The columns of a binary log."""

    path: Path
    series: tuple[Series, ...]

    @property
    def times(self) -> tuple[str, ...]:
        """Names of the times beside the columns."""
        stamped = any(one.stamp_s is not None for one in self.series)
        own = any(one.log_s is not None for one in self.series)
        return (LOG_TIME,) * own + (HEADER_STAMP,) * stamped

    @property
    def layout(self) -> Format:
        """The names and units as those of a table, the times first."""
        names = (*self.times, *(one.name for one in self.series))
        units = ("s",) * len(self.times) + tuple(one.unit for one in self.series)
        return Format(",", False, "", names, 0, 1, len(names), units)

    def table(self, indices: Sequence[int], channels: Sequence[Channel], skip_broken: bool) -> DataTable:
        """Time, the first index, and ``channels`` as a table. Raises InputError where they do not belong together."""
        time, own = self.layout.names[indices[0]], len(self.times)
        if indices[0] < own:
            chosen = [self.series[k - own] for k in indices[1:] if k >= own]
            found = [one.stamp_s if time == HEADER_STAMP else one.log_s for one in chosen]
            missing = [one.name for one, at in zip(chosen, found, strict=True) if at is None]
            if missing or len(chosen) < len(channels):
                remedy = "give another column as the time" if missing else "give a column of the log, no time"
                raise self._wrong(f"no {time} of {missing[0] if missing else 'a quantity'}", remedy)
            # A message may hold no figure where a sensor had none.
            whole = [np.isfinite(one.values) for one in chosen]
            tables = [
                np.stack([at[row], one.values[row], 1.0 + np.flatnonzero(row)])
                for one, at, row in zip(chosen, found, whole, strict=True)
                if at is not None
            ]
            return aligned(self.path, channels, tables, 1)
        if min(indices) < own:
            raise self._wrong(f"{self.layout.names[min(indices)]} is the time of messages, no quantity", "correct it")
        chosen = [self.series[k - own] for k in indices]
        lengths = {one.name: one.values.size for one in chosen}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} {size}" for name, size in lengths.items())
            remedy = f"give columns of one length, or column: {LOG_TIME} as the time" if self.times else "give others"
            raise self._wrong(f"columns of different lengths: {told}", remedy)
        return self._finite(np.stack([one.values for one in chosen]), chosen, skip_broken)

    def _finite(self, values: Floats, chosen: Sequence[Series], skip_broken: bool) -> DataTable:
        """The rows in which all figures are finite; InputError for others unless they are to be skipped."""
        bad = ~np.isfinite(values)
        wrong = np.asarray(bad.any(axis=0))
        broken = np.flatnonzero(wrong)
        if broken.size and not skip_broken:
            name = chosen[int(np.argmax(bad[:, broken[0]]))].name
            remedy = "correct or remove the row, or set broken_rows: skip in the measurement file"
            raise self._wrong(f"no finite number in {name}", remedy, int(broken[0]) + 1)
        left_out(self.path, broken.size, values.shape[1], [int(row) + 1 for row in broken[:1]], "no finite number")
        listed = tuple(int(row) + 1 for row in broken[:5])
        whole = DataTable(values, broken.size, listed, 1, np.empty(0, dtype=np.int64))
        return whole.only(~wrong) if broken.size else whole

    def drafted(self) -> list[Series]:
        """Columns for a draft, the time first where messages have their own: all on the times of the fullest channel.

        Of a log without own times: the columns of the length that most have.
        """
        if not self.times:
            size = Counter(one.values.size for one in self.series).most_common(1)[0][0]
            return [one for one in self.series if one.values.size == size and bool(np.isfinite(one.values).all())]
        name = HEADER_STAMP if all(one.stamp_s is not None for one in self.series) else LOG_TIME
        timed = [(one, one.stamp_s if name == HEADER_STAMP else one.log_s) for one in self.series]
        known = [(one, at) for one, at in timed if at is not None and bool(np.isfinite(one.values).all())]
        fullest = max(at.size for _, at in known)
        known = [(one, at) for one, at in known if at.size >= LEAST_OF_FULLEST * fullest]
        base = next(at for _, at in known if at.size == fullest)
        base = np.unique(base)
        ordered = [(one, at, np.argsort(at, kind="stable")) for one, at in known]
        rows = [dataclasses.replace(one, values=np.interp(base, at[o], one.values[o])) for one, at, o in ordered]
        return [Series(name, base, "s"), *rows]

    def _wrong(self, what: str, remedy: str, row: int = 1) -> InputError:
        return wrong(self.path, row, what, remedy)


def opened(path: Path) -> BinaryLog | None:
    """The columns of a binary log; None for a file of text. Raises InputError for one that cannot be read."""
    kind: Kind | None = ("a bag of ROS 2", _bag) if path.is_dir() else None
    if path.is_file():
        with open(path, "rb") as file:
            first = file.read(16)
        kind = next((kind for sign, kind in KINDS.items() if first.startswith(sign)), None)
    if kind is None:
        return None
    words, read = kind
    try:
        series = [one for one in read(path) if one.values.size >= FEWEST]
    except (InputError, PermissionError):
        raise
    except ImportError as error:
        what = f"{words}; the package {error.name} that reads it is not installed"
        raise wrong(path, 1, what, EXTRA) from None
    except Exception as error:  # each of the libraries has errors of its own for a damaged file
        what = f"cannot be read as {words}: {str(error) or type(error).__name__}"
        raise wrong(path, 1, what, "check the file, or export the data as CSV") from None
    if not series:
        remedy = "check the file: columns of figures, or messages with figures, are needed"
        raise wrong(path, 1, f"{words} without columns of figures", remedy)
    return BinaryLog(path, tuple(series))


def is_bag(path: Path) -> bool:
    """Whether the path is the folder of a bag of ROS 2."""
    return (path / "metadata.yaml").is_file()


Kind = tuple[str, Callable[[Path], Iterator[Series]]]


def _figures(array: Any) -> Floats | None:
    """The array as figures, dates in seconds from the first; None for one of text or of objects."""
    found = np.asarray(array)
    if found.dtype.kind == "M":
        moments = found.astype("datetime64[ns]").astype(np.int64)
        return np.asarray((moments - moments.flat[0]) / NS_IN_S) if moments.size else None
    if found.dtype.kind == "m":
        return np.asarray(found.astype("timedelta64[ns]").astype(np.int64) / NS_IN_S)
    return np.asarray(found, dtype=float) if found.dtype.kind in "biuf" else None


def _columns_of(name: str, array: Any, unit: str = "") -> Iterator[Series]:
    """The columns of an array: one of a vector, several of a table with few columns or few rows."""
    figures = _figures(array)
    if figures is None:
        return
    table = np.squeeze(figures)
    if table.ndim == 1:
        yield Series(name, table, unit)
    elif table.ndim == 2 and min(table.shape) <= LONGEST_ARRAY:
        long = table if table.shape[0] >= table.shape[1] else table.T
        for k, row in enumerate(long.T):
            yield Series(f"{name}[{k}]", np.ascontiguousarray(row), unit)


def _parquet(path: Path) -> Iterator[Series]:
    parquet = importlib.import_module("pyarrow.parquet")
    table = parquet.read_table(path)
    for field, column in zip(table.schema, table.columns, strict=True):
        said = field.metadata or {}
        unit = (said.get(b"unit") or said.get(b"units") or b"").decode("utf-8", "replace")
        yield from _columns_of(field.name, column.to_numpy(), unit)


def _hdf5(path: Path) -> Iterator[Series]:
    """The data sets of an HDF5 file; MATLAB's files of version 7.3 are such files."""
    h5py = importlib.import_module("h5py")
    found: list[Series] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.shape is None or name.startswith("#"):
            return
        stated = item.attrs.get("unit", item.attrs.get("units", ""))
        unit = stated.decode("utf-8", "replace") if isinstance(stated, bytes) else str(stated)
        if item.dtype.names:
            for field in item.dtype.names:
                found.extend(_columns_of(f"{name}/{field}", item[field]))
        else:
            found.extend(_columns_of(name, item[()], unit))

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    yield from found


def _matlab(path: Path) -> Iterator[Series]:
    from scipy.io import loadmat

    for name, value in loadmat(str(path), simplify_cells=True).items():
        if not name.startswith("__"):
            yield from _of_structure(name, value)


def _of_structure(name: str, value: Any) -> Iterator[Series]:
    """The vectors inside a structure; one with a Name and Data, as dSPACE writes, by its name."""
    if isinstance(value, dict):
        if isinstance(value.get("Name"), str) and "Data" in value:
            yield from _columns_of(value["Name"], value["Data"])
            return
        for key, item in value.items():
            yield from _of_structure(f"{name}/{key}", item)
    elif isinstance(value, np.ndarray) and value.dtype.kind != "O":
        yield from _columns_of(name, value)
    elif isinstance(value, list | np.ndarray):
        for k, item in enumerate(value):
            yield from _of_structure(f"{name}[{k}]", item)


def _tdms(path: Path) -> Iterator[Series]:
    tdms = importlib.import_module("nptdms").TdmsFile.read(path)
    begun: list[np.int64] = []
    for group in tdms.groups():
        for channel in group.channels():
            said = channel.properties
            own = None
            if len(channel) and said.get("wf_increment"):
                own = np.asarray(channel.time_track(), dtype=float)
                if said.get("wf_start_time") is not None:
                    begun.append(np.datetime64(said["wf_start_time"], "ns").astype(np.int64))
                    own += (begun[-1] - begun[0]) / NS_IN_S
            for one in _columns_of(f"{group.name}/{channel.name}", channel[:], str(said.get("unit_string", ""))):
                yield dataclasses.replace(one, log_s=own)


def _mcap(path: Path) -> Iterator[Series]:
    reader = importlib.import_module("mcap.reader")
    messages, decoders = _Messages(), dict[int, Callable[[bytes], Any] | None]()
    with open(path, "rb") as file:
        for schema, channel, message in reader.make_reader(file).iter_messages():
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(channel.message_encoding, schema)
            decode = decoders[channel.id]
            if decode is not None:
                messages.add(channel.topic, message.log_time, decode(message.data))
    yield from messages.series()
    if not messages.rows and decoders:
        raise ValueError("its messages are neither JSON nor those of ROS 1 or 2")


def _decoder(encoding: str, schema: Any) -> Callable[[bytes], Any] | None:
    """What makes an object of a message's bytes; None for an encoding that is not read."""
    if encoding == "json":
        return json.loads
    if encoding not in ("ros1", "cdr") or schema is None:
        return None
    typesys = importlib.import_module("rosbags.typesys")
    store, text = typesys.get_typestore(typesys.Stores.EMPTY), schema.data.decode()
    types = typesys.get_types_from_idl if schema.encoding == "ros2idl" else typesys.get_types_from_msg
    store.register(types(text) if schema.encoding == "ros2idl" else types(text, schema.name))
    # Names of ROS 1 have two parts, those of the library three.
    name = schema.name if schema.name.count("/") == 2 else schema.name.replace("/", "/msg/")
    decode = store.deserialize_ros1 if encoding == "ros1" else store.deserialize_cdr
    return lambda raw: decode(raw, name)


def _bag(path: Path) -> Iterator[Series]:
    highlevel, typesys = importlib.import_module("rosbags.highlevel"), importlib.import_module("rosbags.typesys")
    usual = typesys.get_typestore(typesys.Stores.LATEST)
    messages = _Messages()
    with highlevel.AnyReader([path], default_typestore=usual) as bag:
        # A bag of ROS 2 may hold messages whose definition it does not have.
        known = [one for one in bag.connections if one.msgtype in bag.typestore.fielddefs]
        if not known:
            types = ", ".join(sorted({one.msgtype for one in bag.connections}))
            raise ValueError(f"it has no definitions of its messages ({types}); convert it to MCAP, which has them")
        for connection, at, raw in bag.messages(connections=known):
            messages.add(connection.topic, at, bag.deserialize(raw, connection.msgtype))
    yield from messages.series()


def _json_lines(path: Path) -> Iterator[Series]:
    """The fields of a log with one object a line, from the lines that have those of most."""
    with open(path, encoding="utf-8", errors="replace") as file:
        rows = list[dict[str, float]]()
        for line in filter(str.strip, file):
            rows.append({})
            with suppress(ValueError):  # a line that was cut has no figures
                rows[-1] = {name.lstrip("/"): value for name, value in _flat("", json.loads(line))}
    names, often = Counter(frozenset(row) for row in rows).most_common(1)[0]
    if often < (1.0 - LEAST_OF_FULLEST) * len(rows):
        odd = len(rows) - often
        raise ValueError(f"{odd} of {len(rows)} lines have other fields than most; write all in each line")
    kept = [row for row in rows if frozenset(row) == names]
    for name in kept[0] if kept else ():
        yield Series(name, np.array([row[name] for row in kept]))


class _Messages:
    """Figures of messages by topic and field, with the times of the log and of the messages' headers, in ns."""

    def __init__(self) -> None:
        self.rows: dict[str, tuple[list[int], list[int | None], list[float]]] = {}

    def add(self, topic: str, log_ns: int, message: Any) -> None:
        """Add one message."""
        stamp = _stamp_ns(_parts(message).get("header"))
        for name, value in _flat(topic, message):
            logged, stamps, values = self.rows.setdefault(name, ([], [], []))
            logged.append(log_ns)
            stamps.append(stamp)
            values.append(value)

    def series(self) -> Iterator[Series]:
        """The columns, with times in seconds from the first message."""
        first = min((logged[0] for logged, _, _ in self.rows.values()), default=0)
        stamps = [one for _, stamps, _ in self.rows.values() for one in stamps[:1] if one is not None]
        begun = min(stamps, default=0)
        for name, (logged, stamped, values) in self.rows.items():
            headed = all(stamped)
            yield Series(
                name,
                np.array(values),
                "",
                (np.array(logged, dtype=np.int64) - first) / NS_IN_S,
                (np.array(stamped, dtype=np.int64) - begun) / NS_IN_S if headed else None,
            )


def _parts(message: Any) -> dict[str, Any]:
    """Fields of a message: of JSON, or of a message of ROS; empty for anything else."""
    if isinstance(message, dict):
        return message
    if dataclasses.is_dataclass(message):
        return {field.name: getattr(message, field.name) for field in dataclasses.fields(message)}
    return {}


def _stamp_ns(header: Any) -> int | None:
    """Time in the header of a message; None without one, or where it was never set."""
    stamp = _parts(_parts(header).get("stamp"))
    sec = stamp.get("sec", stamp.get("secs"))
    if sec is None:
        return None
    return int(sec) * 10**9 + int(stamp.get("nanosec", stamp.get("nsec", stamp.get("nsecs", 0)))) or None


def _flat(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Figures inside a message with their names; those of joints by the names of the joints."""
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield name, float(value)
    elif isinstance(value, list | tuple | np.ndarray):
        if len(value) <= LONGEST_ARRAY:
            for k, item in enumerate(value):
                yield from _flat(f"{name}[{k}]", item)
    else:
        parts = _parts(value)
        called = parts.get("name")
        joints = called if isinstance(called, list) and all(isinstance(one, str) for one in called) else []
        for key, item in parts.items():
            if key in ("header", "__msgtype__"):
                continue
            if joints and isinstance(item, list | np.ndarray) and len(item) == len(joints):
                for joint, one in zip(joints, item, strict=True):
                    yield from _flat(f"{name}/{joint}/{key}", one)
            else:
                yield from _flat(f"{name}/{key}", item)


KINDS: dict[bytes, Kind] = {
    b"\x89HDF\r\n": ("an HDF5 file", _hdf5),
    b"MATLAB 7.3": ("a file of MATLAB", _hdf5),
    b"MATLAB 5.0": ("a file of MATLAB", _matlab),
    b"PAR1": ("a Parquet file", _parquet),
    b"TDSm": ("a TDMS file of LabVIEW", _tdms),
    b'{"': ("a log of JSON lines", _json_lines),
    b"\x89MCAP0": ("an MCAP log", _mcap),
    b"#ROSBAG": ("a bag of ROS 1", _bag),
    b"SQLite format 3": ("a bag of ROS 2", _bag),
}
