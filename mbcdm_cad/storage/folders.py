"""Files and folders that are written completely or not at all: under a temporary name, renamed in one step.

``manifest.json`` lists the files of a build, their input and the versions used.
"""

import ctypes
import errno
import glob
import hashlib
import json
import os
import platform
import secrets
import shutil
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

import filelock

import mbcdm_cad
from mbcdm_cad.errors import InputError, OutputError, Problem

_STALE_S = 3600.0


def aside(target: Path) -> Path:
    """An unused path beside ``target``, for a file or folder that will replace it; its name tells whose it is."""
    return target.with_name(f".{target.name}.new-{_machine()}{os.getpid():08x}{secrets.token_hex(2)}")


@cache
def _machine() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:4]


def asides(name: str = "*") -> str:
    """Pattern of the names that :func:`aside` gives for files whose names have the pattern ``name``."""
    return f".{name}.new-" + "[0-9a-f]" * 16


def is_left(path: Path) -> bool:
    """Whether an aside is of a dead process; on another machine, or where that cannot be told, older than an hour."""
    try:
        if os.name == "posix" and path.name[-16:-12] == _machine():
            os.kill(int(path.name[-12:-4], 16), 0)
        return abs(time.time() - path.stat().st_mtime) > _STALE_S
    except ProcessLookupError:
        return True
    except OSError:  # gone meanwhile, or of a living process of another user
        return False


def refuse_missing_folder(path: Path) -> None:
    """Raise ``InputError`` if the folder into which ``path`` is written does not exist."""
    if not path.parent.is_dir():
        what = f"there is no folder {path.parent}"
        raise InputError([Problem(str(path), 1, "", what, remedy="make it first, or choose another path")])


def write_whole(files: Mapping[Path, bytes], *, durable: bool = True) -> None:
    """Write all files or none. Raises OSError that names the file concerned.

    Missing folders are made, and what dead processes have left of these files is removed. With ``durable`` the content
    is on the disk before a file gets its name, so that even after a crash of the machine the old or the new file exists
    completely; without, this holds only for a crash of the program. Of several files that are ``durable``, those that a
    process has replaced before it died become the old ones again with the next call for one of their folders.
    """
    written: dict[Path, Path] = {}
    try:
        for target, content in files.items():
            new = aside(target)
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                if target.is_dir():
                    raise IsADirectoryError(21, "is a folder", str(target))
                for record in filter(is_left, target.parent.glob(asides(_SET))):
                    _undo(record)
                _remove(*filter(is_left, target.parent.glob(asides(glob.escape(target.name)))))
                with open(new, "xb") as file:
                    written[new] = target
                    file.write(content)
                    if durable:
                        file.flush()
                        os.fsync(file.fileno())
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(target)) from error
        with _all_or_none(files) if durable and len(files) > 1 else nullcontext():
            for new, target in written.items():
                new.replace(target)
    finally:
        _remove(*written)


_SET = "mbcdm-set"


@contextmanager
def _all_or_none(targets: Collection[Path]) -> Iterator[None]:
    """Replace files within the block: all, or none where it fails, or, by :func:`_undo`, where the process dies.

    A record stands in each of their folders meanwhile: only while all of them do is there anything to undo.
    """
    whole = [target.absolute() for target in targets]
    records = [aside(folder / _SET) for folder in {target.parent for target in whole}]
    before = {target: aside(target) if os.path.lexists(target) else None for target in whole}
    kept = [path for path in before.values() if path]
    try:
        for target, path in before.items():
            if path:
                _link(target, path)
        for record in records:
            record.write_text(json.dumps([records, list(before.items())], default=str), "utf-8")
        try:
            yield
            records[0].unlink()  # from here on there is nothing to undo
        except BaseException:
            _undo(records[0])
            raise
    finally:
        _remove(*records, *kept)


def _undo(record: Path) -> None:
    """Put back what was there before a set of files that was not finished, but for what was changed since."""
    records, before = [record], list[Any]()
    with suppress(ValueError):  # where it is not whole, nothing was replaced yet
        records, before = json.loads(record.read_text("utf-8"))
    if all(map(os.path.exists, records)):
        begun = record.stat().st_mtime
        for target, kept in before:
            if os.path.lexists(target) and os.lstat(target).st_mtime > begun:
                continue
            if kept is None:
                Path(target).unlink(missing_ok=True)
            elif os.path.lexists(kept):
                os.replace(kept, target)
    _remove(*records, *(kept for _, kept in before if kept))


def _remove(*paths: str | Path) -> None:
    """Remove what is there and may be removed; what stays goes with a later run."""
    for path in paths:
        with suppress(OSError):
            os.unlink(path)


def _link(path: Path, place: Path) -> None:
    try:
        os.link(path, place, follow_symlinks=False)
    except OSError:  # a file system without hard links
        shutil.copy2(path, place, follow_symlinks=False)


MANIFEST_NAME = "manifest.json"
_GENERATOR = "mbcdm_cad"
_FORMAT = 1


@dataclass(frozen=True)
class FileEntry:
    """One file of the output: its SHA-256 (hex) and size in bytes."""

    sha256: str
    size: int


@dataclass(frozen=True)
class Manifest:
    """The content of ``manifest.json`` without the versions.

    ``design_sha256`` is the hash of the design alone; ``inputs_sha256`` that of all inputs of the output (design,
    options, program, versions): with equal inputs and unchanged files there is nothing to build. ``failed_checks`` are
    the ids of the checks that fail; where there are any, ``forced`` is true.
    """

    design_sha256: str
    inputs_sha256: str
    forced: bool = False
    failed_checks: tuple[str, ...] = ()
    files: dict[str, FileEntry] = field(default_factory=dict)

    def text(self) -> str:
        """The file's text: sorted keys, no time."""
        content = {"generator": _GENERATOR, "format": _FORMAT, "versions": versions(), **asdict(self)}
        return json.dumps(content, indent=1, sort_keys=True) + "\n"


@cache
def versions() -> dict[str, str]:
    """Versions that the output depends on: this package, its libraries, Python. No import of them."""
    from importlib import metadata  # a tenth of the start of a command, and few ask

    return {
        "mbcdm_cad": mbcdm_cad.__version__,
        "cadquery": metadata.version("cadquery"),
        **{name: metadata.version(name) for name in ("cadquery-ocp", "ezdxf", "matplotlib", "numpy")},
        "python": platform.python_version(),
    }


_NO_FILE = (FileNotFoundError, NotADirectoryError, IsADirectoryError)


def read_manifest(folder: Path) -> Manifest | None:
    """The manifest of an output folder; None if there is none, or if this program did not write it.

    Raises ``OSError`` if it cannot be read: without it nobody knows which files are the user's.
    """
    try:
        content = json.loads((folder / MANIFEST_NAME).read_text("utf-8"))
        if content["generator"] != _GENERATOR or content["format"] != _FORMAT:
            return None
        return Manifest(
            content["design_sha256"],
            content["inputs_sha256"],
            content["forced"],
            tuple(content["failed_checks"]),
            {name: FileEntry(**entry) for name, entry in content["files"].items()},
        )
    except (*_NO_FILE, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def file_entry(path: Path) -> FileEntry:
    """Hash and size of a file. Raises ``OSError`` if it cannot be read."""
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    return FileEntry(digest, path.stat().st_size)


def altered_files(folder: Path, manifest: Manifest) -> list[str]:
    """Names of the files that are missing or differ from the manifest, sorted."""

    def is_as_written(name: str, entry: FileEntry) -> bool:
        path = folder / name
        try:
            return path.stat().st_size == entry.size and file_entry(path) == entry
        except OSError:
            return False

    return sorted(name for name, entry in manifest.files.items() if not is_as_written(name, entry))


_LOCK_TIMEOUT_S = 600.0


class OutputFolder:
    """A folder being written. ``path`` is the temporary folder, whose content becomes the output at the end."""

    def __init__(self, path: Path, target: Path) -> None:
        self.path = path
        self._target = target

    def write(self, name: str, data: bytes | str) -> None:
        """Write one file, ``name`` with forward slashes below the folder.

        Raises ``ValueError`` for a name that leaves the folder or is the manifest's, ``OutputError`` if the system
        refuses (disk full, say).
        """
        path = self.path / _checked(name)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data.encode("utf-8") if isinstance(data, str) else data)
        except OSError as error:
            raise _refused(self._target, error) from error


@contextmanager
def output_folder(
    target: Path,
    manifest: Manifest,
    timeout_s: float = _LOCK_TIMEOUT_S,
    *,
    design: Path | None = None,
    without: str = "",
) -> Iterator[OutputFolder]:
    """As :func:`whole_folder`, with a manifest by which a later build knows its own files.

    ``design``: the design file that it is made from, which the folder records. ``without``: a file that goes too.

    Files in ``target`` that its manifest does not list belong to the user and are kept. ``files`` of ``manifest`` is
    filled in here. Raises ``OutputError`` also if this program did not make ``target``, or made it from another design
    file.
    """
    target = target.resolve()

    def refuse(folder: Path) -> None:
        refuse_other_origin(folder, design)
        if folder.is_dir() and any(folder.iterdir()) and read_manifest(folder) is None:
            raise OutputError(
                f"{folder}: not empty, and not made by this program (no {MANIFEST_NAME} of its own); "
                "empty it or choose another folder with --out"
            )

    with whole_folder(target, refuse, timeout_s) as staging:
        yield OutputFolder(staging, target)
        try:
            # Write the manifest, and keep the files that belong to the user.
            names = [path.relative_to(staging).as_posix() for path in _files_below(staging)]
            files = {name: file_entry(staging / name) for name in names}
            (staging / MANIFEST_NAME).write_text(replace(manifest, files=files).text(), "utf-8")
            before = read_manifest(target)
            if before is not None:
                _bring_along(target, staging, {*before.files, MANIFEST_NAME, ORIGIN_NAME, without})
            if design is not None and design.is_file():
                (staging / ORIGIN_NAME).write_text(origin_text(target, design), "utf-8")
        except OSError as error:
            raise _refused(target, error) from error


def write_folder(
    target: Path, files: Mapping[str, bytes], refuse: Callable[[Path], None], *, keep: bool = False
) -> None:
    """Make ``target`` hold just these files, by name, or with ``keep`` these and others; see :func:`whole_folder`."""
    with whole_folder(target, refuse) as staging:
        folder = OutputFolder(staging, target)
        for name, data in files.items():
            folder.write(name, data)
        if keep:
            _bring_along(target, staging, files)


@contextmanager
def whole_folder(target: Path, refuse: Callable[[Path], None], timeout_s: float = _LOCK_TIMEOUT_S) -> Iterator[Path]:
    """A new folder beside ``target`` that replaces it when the block ends without an exception.

    If anything fails before (an exception, a full disk, SIGKILL), ``target`` does not change; leftovers beside it
    (``.NAME.new-*``, ``.NAME.lock``) are removed by the next call. Processes that write the same folder wait for each
    other. ``refuse`` is called with ``target`` under the lock and raises ``OutputError`` if it must not be replaced.

    Raises ``OutputError`` if another process holds the folder for longer than ``timeout_s``, or if the system refuses
    to write.
    """
    target = target.resolve()
    with ExitStack() as held:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            held.enter_context(locked(target.with_name(f".{target.name}.lock"), timeout_s))
        except filelock.Timeout as error:
            raise OutputError(
                f"{target}: another build has been writing here for {timeout_s:g} s; wait for it, stop it, or choose "
                "another folder with --out"
            ) from error
        except OSError as error:
            raise _refused(target, error) from error
        with _staging(target, refuse) as folder:
            yield folder


@contextmanager
def locked(path: Path, timeout_s: float) -> Iterator[None]:
    """Hold the lock file ``path`` for the block; the system releases it when a process dies.

    Raises ``filelock.Timeout`` if another process holds it for longer.
    """
    with filelock.FileLock(path, timeout=timeout_s):
        try:
            yield
        finally:
            if os.name == "posix":
                # While it is held: who waits for it sees that the file it has opened is no longer there, and opens
                # the next. Elsewhere a file that somebody has open cannot be removed: it stays.
                with suppress(OSError):
                    path.unlink()


@contextmanager
def _staging(target: Path, refuse: Callable[[Path], None]) -> Iterator[Path]:
    """The temporary folder, renamed to ``target`` at the end; called under the lock."""
    old = target.with_name(f".{target.name}.before-swap")
    staging = aside(target)
    try:
        try:
            recover(target, old)
            # What builds that died have left: under the lock no living build's folder is among them.
            for path in target.parent.glob(asides(glob.escape(target.name))):
                shutil.rmtree(path, ignore_errors=True)
            refuse(target)
            staging.mkdir()
        except OSError as error:
            raise _refused(target, error) from error
        yield staging
        try:
            for path in (staging, *staging.rglob("*")):
                if path.is_symlink() or (path.is_file() and path.stat().st_nlink > 1):
                    continue  # linked from the folder before: on the disk already, and perhaps not ours to open
                _sync(path)
            replace_folder(staging, target, old)
        except OSError as error:
            raise _refused(target, error) from error
        with suppress(OSError):  # the output is there, and whole
            _sync(target.parent)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _bring_along(target: Path, staging: Path, made: Collection[str]) -> None:
    """Link what is in ``target``, except the files ``made`` by this program, into the folder that replaces it."""
    for path in _files_below(target) if target.exists() else ():
        name = path.relative_to(target)
        if name.as_posix() in made:
            continue
        place = staging / name
        if os.path.lexists(place):
            raise OutputError(
                f"{path}: this build makes a file of that name, but the one there is not from a build before; "
                "move it away or choose another folder with --out"
            )
        place.parent.mkdir(parents=True, exist_ok=True)
        _link(path, place)


def _files_below(folder: Path) -> Iterator[Path]:
    """Every file and link; raises ``OSError`` for a folder that cannot be listed, which ``rglob`` would pass over."""
    for path in sorted(folder.iterdir()):
        if path.is_dir() and not path.is_symlink():
            yield from _files_below(path)
        else:
            yield path


def _checked(name: str) -> PurePosixPath:
    path = PurePosixPath(name)
    plain = name and not path.is_absolute() and ".." not in path.parts and "\\" not in name and "\0" not in name
    if not plain or path.parts == (MANIFEST_NAME,) or not path.parts:
        raise ValueError(f"output file {name!r}: must be a plain relative name below the folder, not {MANIFEST_NAME}")
    return path


def _sync(path: Path) -> None:
    """Flush a file or a folder to the disk, so that a full disk is noticed before the swap."""
    if os.name != "posix" and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDONLY if os.name == "posix" else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _refused(target: Path, error: OSError) -> OutputError:
    where = f" ({error.filename})" if error.filename else ""
    return OutputError(
        f"{target}: cannot write: {error.strerror or error}{where}; make room or rights, or choose another folder with "
        "--out. What was there before is unchanged"
    )


_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
_NOT_OFFERED = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM}


def replace_folder(new: Path, target: Path, old: Path) -> None:
    """Replace ``target`` by ``new``, and remove the old one. All three lie in one parent folder.

    On Linux the two are exchanged in one step of the file system. Elsewhere the target is first moved to ``old``; if
    the process dies before the second rename, :func:`recover` puts it back.
    """
    if not target.exists():
        new.rename(target)
    elif _exchange(new, target):
        shutil.rmtree(new, ignore_errors=True)
    else:
        target.rename(old)
        try:
            new.rename(target)
        finally:
            recover(target, old)


def recover(target: Path, old: Path) -> None:
    """Finish or undo a :func:`replace_folder` that died between its two renames."""
    if old.exists():
        if target.exists():
            shutil.rmtree(old, ignore_errors=True)
        else:
            old.rename(target)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two folders in one step; False if the system or the file system cannot do it."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None) if os.name == "posix" else None
    if renameat2 is None:
        return False
    if renameat2(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _NOT_OFFERED:
        return False
    raise OSError(number, os.strerror(number), str(first), None, str(second))


ORIGIN_NAME = ".design-file"


def write_from(design: Path, target: Path, files: Mapping[str, bytes]) -> None:
    """Write files by name into ``target``, with the record, all or none; others in it stay.

    Raises ``OutputError`` as :func:`refuse_other_origin` and :func:`whole_folder`.
    """
    record = {ORIGIN_NAME: origin_text(target, design).encode()} if design.is_file() else {}
    write_folder(target, {**files, **record}, lambda folder: refuse_other_origin(folder, design), keep=True)


def origin_text(target: Path, design: Path) -> str:
    """Content of the record in ``target``."""
    source, folder = design.resolve(), target.resolve()
    try:
        return Path(os.path.relpath(source, folder)).as_posix() + "\n"
    except ValueError:  # another drive of Windows
        return source.as_posix() + "\n"


def refuse_other_origin(target: Path, design: Path | None) -> None:
    """Raise ``OutputError`` if ``target`` holds the output of another design file that is still there, or is a file.

    Anything goes for a design without a file, and for a folder without a record.
    """
    there = next(path for path in (target, *target.absolute().parents) if path.exists())
    if not there.is_dir():
        raise OutputError(f"{there}: there is a file of that name; choose another folder with --out")
    try:
        other = (target / (target / ORIGIN_NAME).read_text("utf-8").strip()).resolve()
        if design is None or not design.is_file() or not other.is_file() or other.samefile(design):
            return
    except (OSError, ValueError, RuntimeError):  # no record, or one that names no path
        return
    raise OutputError(
        f"{target}: holds the output of {other}, another design file with the same name as {design}; change name in "
        "one of the two files, choose another folder with --out, or remove this folder if it is no longer needed"
    )
