"""The server of mbcdm watch: it serves only requests with the secret address, and only files of the output."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import aiohttp
import cadquery as cq
import pytest

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.live import watch
from mbcdm_cad.live.preview import Previewer
from mbcdm_cad.live.watch import HOST, Server, WatchState
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.meshing import make_part_files
from mbcdm_cad.workshop.store import StoredPart
from tests.support.reference import REFERENCE

Ask = Callable[[Server, aiohttp.ClientSession], Awaitable[None]]


def served(folder: Path, ask: Ask) -> None:
    """Run ``ask`` against a server of its own over ``folder``."""

    async def main() -> None:
        server = Server(WatchState(), [folder])
        await server.start(0)
        try:
            async with aiohttp.ClientSession() as session:
                await ask(server, session)
        finally:
            await server.stop()

    # In a thread of its own: the browser's driver, which other tests start, keeps a loop running in this one.
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, main()).result()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "secret.txt").write_text("not for others")
    inside = tmp_path / "out"
    (inside / "parts").mkdir(parents=True)
    (inside / "parts" / "drum.step").write_text("ISO-10303-21;")
    (inside / "link").symlink_to(tmp_path / "secret.txt")
    return inside


def test_only_the_address_with_its_token_and_this_host_is_answered(folder: Path) -> None:
    async def ask(server: Server, session: aiohttp.ClientSession) -> None:
        origin = server.address.rsplit("/", 2)[0]
        assert origin.startswith(f"http://{HOST}:")
        wanted = {
            server.address: 200,
            f"{origin}/": 404,
            f"{origin}/wrong/": 404,
            f"{origin}/wrong/events": 404,
            f"{origin}/wrong/parts/drum.step": 404,
        }
        for address, status in wanted.items():
            async with session.get(address) as answer:
                assert answer.status == status, address
        async with session.get(server.address, headers={"Host": "elsewhere.example"}) as answer:
            assert answer.status == 404  # a foreign name that was made to point here

    served(folder, ask)


@pytest.mark.parametrize(
    ("place", "status"),
    [
        ("parts/drum.step", 200),
        ("parts", 404),
        ("parts/none.step", 404),
        ("../secret.txt", 404),
        ("%2e%2e/secret.txt", 404),
        ("parts/..%2f..%2fsecret.txt", 404),
        ("link", 404),
        ("/etc/passwd", 404),
        ("a%00b", 404),
        ("a" * 5000, 404),
    ],
)
def test_files_come_from_the_output_alone(folder: Path, place: str, status: int) -> None:
    async def ask(server: Server, session: aiohttp.ClientSession) -> None:
        import yarl

        async with session.get(yarl.URL(server.address + place, encoded=True)) as answer:
            assert answer.status == status, (place, await answer.text())

    served(folder, ask)


def test_an_open_page_hears_of_every_change_and_of_the_end(folder: Path) -> None:
    async def ask(server: Server, session: aiohttp.ClientSession) -> None:
        async with session.get(server.address + "events") as answer:
            heard = [json.loads((await answer.content.readline()).removeprefix(b"data: "))]
            await answer.content.readline()
            server.state.save, server.state.stage = 7, "broken"
            server.tell()
            heard.append(json.loads((await answer.content.readline()).removeprefix(b"data: ")))
            assert [(state["save"], state["stage"]) for state in heard] == [(0, "drawing"), (7, "broken")]
            await server.stop()
            assert await asyncio.wait_for(answer.content.read(), 5.0) == b"\n"

    served(folder, ask)


def test_pages_that_are_closed_or_do_not_read_end_and_cost_no_memory(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(watch, "_SLOW_S", 0.3)

    async def ask(server: Server, session: aiohttp.ClientSession) -> None:
        where, token = server.address.split("/")[2:4]
        opened = [await asyncio.open_connection(*where.split(":")) for _ in range(40)]
        opened[0][1].write(b"GET /half")
        for _, writer in opened[1:]:
            writer.write(f"GET /{token}/events HTTP/1.1\r\nHost: {where}\r\n\r\n".encode())
        opened[1][1].transport.abort()
        server.state.message = "x" * 2_000_000
        for _ in range(20):
            server.tell()
            await asyncio.sleep(0.05)
        answers = [await asyncio.wait_for(reader.read(), 5.0) for reader, _ in [opened[0], *opened[2:]]]
        assert answers[0] == b"" and sum(b"503" in answer[:40] for answer in answers) >= 6
        async with session.get(server.address) as answer:
            assert answer.status == 200

    served(folder, ask)
    assert not caplog.records, "a page that goes is no fault of the server"


def test_a_taken_port_is_told_in_one_sentence(folder: Path) -> None:
    async def ask(server: Server, session: aiohttp.ClientSession) -> None:
        port = int(server.address.split(":")[2].split("/")[0])
        with pytest.raises(MbcdmError, match=f"--port: cannot listen on {HOST}:{port}.*choose another"):
            await Server(WatchState(), [folder]).start(port)

    served(folder, ask)


# The preview of a design under `mbcdm watch`: the order of its work, and a part without a mesh.


def test_pulleys_come_first_and_then_the_most_work(tmp_path: Path) -> None:
    previewer = Previewer(tmp_path, Cache(None), lambda: None)
    previewer._lengths = {"drum": 900, "frame": 500, "guide": 20, "input_pulley": 90, "dowel": 4}
    names = ["dowel", "frame", "drum", "input_pulley", "guide"]
    assert previewer._in_order(names, {"guide", "input_pulley"}) == ["input_pulley", "guide", "drum", "frame", "dowel"]
    assert previewer._in_order(["collar"], {"guide"}) == ["collar"] and previewer._in_order([], set()) == []


def test_step_is_there_before_the_mesh_and_no_stl_of_an_older_state_stays(tmp_path: Path) -> None:
    previewer, metal = Previewer(tmp_path, Cache(None), lambda: None), load_design(REFERENCE).drive.guide_material
    solid = cq.Solid.makeBox(1, 2, 3)
    meshed = make_part_files("rope", solid, metal, 0.01, on_step=previewer.write_step)
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["rope.step"]
    previewer._write({"rope": StoredPart("key", meshed)})
    assert sorted(path.name for path in (tmp_path / "parts").iterdir()) == ["rope.step", "rope.stl"]
    bare = make_part_files("rope", solid, metal, None)
    previewer._write({"rope": StoredPart("other key", bare)})
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["rope.step"]
    assert bare.step == meshed.step and bare.shape == meshed.shape and bare.mesh.is_empty
