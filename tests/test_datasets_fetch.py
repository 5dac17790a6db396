"""Fetching: from a local git remote and a local server, all of it or nothing."""

import errno
import hashlib
import io
import os
import signal
import subprocess
import sys
import threading
import time
import zipfile
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from mobility_imu.datasets import catalogue, dataset_folder, fetch_dataset
from mobility_imu.datasets.files import Note
from mobility_imu.datasets.folders import NOTE
from mobility_imu.datasets.git import GitFiles, blob_id, fetch_commit
from mobility_imu.errors import InputError

GIT, HTTP = "one-hinge", "wheelmove-id-sample"


@pytest.fixture(autouse=True)
def machine(monkeypatch, tmp_path):
    """A home and a cache of the test's own."""
    for name in ("MOBILITY_IMU_RECORDINGS", "MOBILITY_IMU_DATA"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("MOBILITY_IMU_CACHE", str(tmp_path / "deep" / "cache"))
    yield
    assert list((tmp_path / "home").iterdir()) == []  # nothing outside the cache


@pytest.fixture
def cache(tmp_path):
    return tmp_path / "deep" / "cache"


@pytest.fixture(scope="module")
def remote(tmp_path_factory):
    """A repository whose older commit is wanted; address and commit."""
    folder = tmp_path_factory.mktemp("remote")

    def git(*arguments):
        identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
        command = ["git", "-C", str(folder), *identity, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    git("init", "-q")
    for setting in ("uploadpack.allowFilter", "uploadpack.allowAnySHA1InWant"):
        git("config", setting, "true")
    (folder / "some data").mkdir()
    (folder / "some data" / "wanted ü.csv").write_text("1,2\n")
    (folder / "some data" / "large.bin").write_bytes(bytes(range(256)) * 400)
    git("add", ".")
    git("commit", "-qm", "first")
    commit = git("rev-parse", "HEAD")
    (folder / "some data" / "wanted ü.csv").write_text("changed since\n")
    git("commit", "-qam", "second")
    return f"file://{folder}", commit


class Recipe:
    """Copies what is wanted; ``disturb`` is called before it ends."""

    def __init__(self, disturb=lambda out: None):
        self.disturb = disturb
        self.files = None

    def wanted(self, path):
        return path.endswith(".csv")

    def convert(self, files, out):
        self.files = files
        for name in files.names:
            if self.wanted(name):
                out.text(Path(name).name, files.read(name).decode())
        self.disturb(out)
        return Note(done=["copied"], warnings=["odd"])


@pytest.fixture
def prepare(monkeypatch, remote):
    """Put a local origin, or another one, and a small recipe behind the name."""

    def prepare(recipe=None, *, name=GIT, **changed):
        entry = {"origin": remote[0], "commit": remote[1]} if name == GIT else {}
        dataset = replace(catalogue.DATASETS[name], **(entry | changed))
        monkeypatch.setitem(catalogue.DATASETS, name, dataset)
        recipe = recipe or Recipe()
        monkeypatch.setattr("mobility_imu.datasets.obtain._recipe", lambda dataset: recipe)
        return recipe

    return prepare


def fails(cache, says, name=GIT):
    """The fetch is refused in one line, and nothing is left, not even the cache's folder."""
    with pytest.raises(InputError, match=says) as error:
        fetch_dataset(name)
    assert "\n" not in str(error.value)
    assert not cache.parent.exists()


class TestGit:
    def test_the_fixed_commit_with_a_note(self, prepare, cache, remote):
        prepare()
        said = []
        folder = fetch_dataset(GIT, progress=said.append)
        assert folder == cache / GIT == dataset_folder(GIT)
        assert (folder / "wanted ü.csv").read_text() == "1,2\n"  # not the newer content
        note = (folder / NOTE).read_text()
        for part in (*remote, "MIT", "- copied", "- odd", "- wanted ü.csv", "1 files"):
            assert part in note
        assert [p.name for p in cache.iterdir()] == [GIT]
        assert said[0].startswith("fetching") and said[-1].startswith("converting")

    def test_only_what_is_wanted_is_transferred(self, remote, tmp_path):
        files = fetch_commit(*remote, tmp_path / "repo", Recipe().wanted)
        assert files.names == ["some data/large.bin", "some data/wanted ü.csv"]
        # Objects that are here, without asking for more.
        command = ["git", "-C", str(files.folder), "cat-file", "--batch-all-objects"]
        here = subprocess.run([*command, "--batch-check"], capture_output=True, text=True).stdout
        assert files.ids["some data/wanted ü.csv"] in here
        assert files.ids["some data/large.bin"] not in here

    def test_a_second_fetch_asks_nobody(self, prepare):
        prepare()
        folder = fetch_dataset(GIT)
        before = (folder / NOTE).stat()
        prepare(origin="file:///nowhere")
        assert fetch_dataset(GIT) == folder
        # Reading may move the time of access, so the whole of stat is not compared.
        after = (folder / NOTE).stat()
        assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)

    def test_folders_have_the_users_rights(self, prepare):
        prepare()
        before = os.umask(0o027)
        try:
            folder = fetch_dataset(GIT)
        finally:
            os.umask(before)
        assert folder.stat().st_mode & 0o777 == 0o750
        assert (folder / NOTE).stat().st_mode & 0o777 == 0o640

    @pytest.mark.parametrize(
        ("changed", "says"),
        [
            ({"origin": "file:///nowhere/at-all"}, "cannot be fetched .*does not appear to be"),
            ({"origin": "https://127.0.0.1:9/a/b"}, "cannot be fetched .* is there a network"),
            ({"commit": "1" * 40}, "cannot be fetched .*not our ref"),
        ],
    )
    def test_an_origin_that_cannot_be_had(self, prepare, cache, changed, says):
        prepare(**changed)
        fails(cache, says)

    def test_an_origin_without_the_files(self, prepare, cache):
        recipe = prepare()
        recipe.wanted = lambda path: False
        fails(cache, "has none of the files that are wanted")

    def test_without_git(self, prepare, cache, monkeypatch, tmp_path):
        prepare()
        monkeypatch.setenv("PATH", str(tmp_path))
        fails(cache, "git is not installed")

    def test_another_repositorys_settings_do_not_reach_it(self, prepare, monkeypatch, tmp_path):
        prepare()
        monkeypatch.setenv("GIT_DIR", str(tmp_path / "other"))
        monkeypatch.setenv("GIT_INDEX_FILE", str(tmp_path / "index"))
        assert (fetch_dataset(GIT) / "wanted ü.csv").exists()

    def test_a_disk_that_is_full_while_git_writes(self, prepare, cache, monkeypatch, tmp_path):
        prepare()
        tools = tmp_path / "bin"
        tools.mkdir()
        (tools / "git").write_text(
            "#!/bin/sh\necho 'fatal: write error: No space left on device' >&2\nexit 128\n"
        )
        (tools / "git").chmod(0o755)
        monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
        fails(cache, "the disk is full; nothing is left there")

    def test_a_server_that_cannot_filter(self, prepare, remote, tmp_path):
        plain = tmp_path / "plain"
        subprocess.run(["git", "clone", "-q", "--bare", remote[0], plain], check=True)
        prepare(origin=f"file://{plain}")
        assert (fetch_dataset(GIT) / "wanted ü.csv").read_text() == "1,2\n"

    def test_content_is_checked_by_its_id(self, remote, tmp_path, monkeypatch):
        files = fetch_commit(*remote, tmp_path / "repo", Recipe().wanted)
        assert blob_id(files.read("some data/wanted ü.csv")) == files.ids["some data/wanted ü.csv"]
        monkeypatch.setattr("mobility_imu.datasets.git._git", lambda *a, **k: b"something else")
        with pytest.raises(InputError, match="damaged"):
            files.read("some data/wanted ü.csv")
        with pytest.raises(InputError, match="no file"):
            GitFiles(files.folder, {}).read("x")


class TestAllOrNothing:
    def test_a_conversion_that_fails(self, prepare, cache):
        def disturb(out):
            raise InputError("a file of the origin is odd")

        prepare(Recipe(disturb))
        fails(cache, "is odd")

    def test_an_interrupt_while_it_converts(self, prepare, cache):
        def disturb(out):
            raise KeyboardInterrupt

        prepare(Recipe(disturb))
        with pytest.raises(KeyboardInterrupt):
            fetch_dataset(GIT)
        assert not cache.parent.exists()

    def test_a_full_disk(self, prepare, cache, monkeypatch):
        def full(path, content):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        prepare()
        monkeypatch.setattr(Path, "write_bytes", full)
        fails(cache, "cannot be written .No space left on device.; nothing is left there")

    def test_a_cache_that_is_a_file(self, prepare, tmp_path, monkeypatch):
        prepare()
        (tmp_path / "file").write_text("mine")
        monkeypatch.setenv("MOBILITY_IMU_CACHE", str(tmp_path / "file"))
        with pytest.raises(InputError, match="cannot be written"):
            fetch_dataset(GIT)
        assert (tmp_path / "file").read_text() == "mine"

    def test_what_was_in_the_cache_stays(self, prepare, cache):
        def disturb(out):
            raise InputError("no")

        (cache / "other").mkdir(parents=True)
        prepare(Recipe(disturb))
        with pytest.raises(InputError):
            fetch_dataset(GIT)
        assert [p.name for p in cache.iterdir()] == ["other"]

    def test_a_folder_of_somebody_else_is_not_touched(self, prepare, cache):
        prepare()
        (cache / GIT).mkdir(parents=True)
        (cache / GIT / "mine.csv").write_text("mine")
        with pytest.raises(InputError, match=r"is there already .* remove it, or move it away"):
            fetch_dataset(GIT)
        assert [p.name for p in (cache / GIT).iterdir()] == ["mine.csv"]

    def test_two_at_once(self, prepare, cache):
        def other_is_faster(out):
            (cache / GIT).mkdir()
            (cache / GIT / NOTE).write_text(f"the other's\n{catalogue.DATASETS[GIT].stamp}\n")

        prepare(Recipe(other_is_faster))
        assert (fetch_dataset(GIT) / NOTE).read_text().startswith("the other's")
        assert [p.name for p in cache.iterdir()] == [GIT]

    def test_what_a_killed_process_left_is_removed_later(self, prepare, cache):
        prepare()
        for name, age_s in ((f".{GIT}-old", 2 * 86400), (f".{GIT}-new", 60)):
            (cache / name).mkdir(parents=True)
            os.utime(cache / name, (time.time() - age_s,) * 2)
        fetch_dataset(GIT)
        assert sorted(p.name for p in cache.iterdir()) == [f".{GIT}-new", GIT]

    @pytest.mark.skipif(not hasattr(os, "killpg"), reason="signals of another system")
    def test_an_interrupt_while_git_works(self, tmp_path, cache):
        """Exit code 130, one line, git and its helpers ended, nothing left."""
        tools = tmp_path / "bin"
        tools.mkdir()
        started = tmp_path / "started"
        (tools / "git").write_text(f"#!/bin/sh\nsleep 300 & echo $! > '{started}'\nwait\n")
        (tools / "git").chmod(0o755)
        environment = os.environ | {"PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"}
        command = [sys.executable, "-m", "mobility_imu", "fetch", GIT]
        # A job in the background of a shell passes on that it ignores interrupts.
        heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
        with subprocess.Popen(
            command, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=heard
        ) as process:
            deadline = time.monotonic() + 60
            while not (started.exists() and started.read_text()) and time.monotonic() < deadline:
                time.sleep(0.02)
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=60)
        assert process.returncode == 130
        assert errors == "mobility-imu: interrupted\n"
        assert not cache.parent.exists()
        assert ended(int(started.read_text()))


def ended(number):
    """Whether a process ends within some seconds."""
    for _ in range(200):
        try:
            os.kill(number, 0)
            state = Path(f"/proc/{number}/stat")
            if state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.02)
    return False


def archive(files):
    """A zip file's content."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as packed:
        for name, content in files.items():
            packed.writestr(name, content)
    return buffer.getvalue()


@contextmanager
def served(content, *, status=200, announced=None):
    """A server on this machine that answers everything with one file."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(status)
            self.send_header("Content-Length", str(announced or len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *arguments):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/SampleData.zip"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def test_without_pooch(prepare, cache, monkeypatch):
    prepare(name=HTTP)
    monkeypatch.setitem(sys.modules, "pooch", None)
    fails(cache, r"pip install 'mobility-imu\[fetch\]'", HTTP)


class TestHttp:
    SAMPLE = archive({"S/": b"", "S/1 - a/T.csv": b"a;b\n1;2\n", "S/Properties.txt": b"x"})

    @pytest.fixture(autouse=True)
    def pooch(self, monkeypatch):
        pytest.importorskip("pooch")
        for name in ("http_proxy", "HTTP_PROXY", "ALL_PROXY", "all_proxy"):
            monkeypatch.delenv(name, raising=False)

    @pytest.fixture
    def sample(self, monkeypatch):
        def sample(content, origin):
            checksum = hashlib.sha256(content).hexdigest()
            dataset = replace(catalogue.DATASETS[HTTP], origin=origin, sha256=checksum)
            monkeypatch.setitem(catalogue.DATASETS, HTTP, dataset)

        return sample

    def test_the_sample_byte_for_byte(self, sample, cache):
        with served(self.SAMPLE) as address:
            sample(self.SAMPLE, address)
            folder = fetch_dataset(HTTP)
        found = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
        assert found == {"1 - a/T.csv", "Properties.txt", NOTE}
        assert (folder / "1 - a" / "T.csv").read_bytes() == b"a;b\n1;2\n"
        assert [p.name for p in cache.iterdir()] == [HTTP]

    def test_another_file(self, sample, cache):
        with served(self.SAMPLE + b"!") as address:
            sample(self.SAMPLE, address)
            fails(cache, "not the file that is expected", HTTP)

    def test_a_transfer_that_is_cut_short(self, sample, cache):
        with served(self.SAMPLE[:50], announced=len(self.SAMPLE)) as address:
            sample(self.SAMPLE, address)
            fails(cache, "not the file that is expected|cannot be downloaded", HTTP)

    def test_a_server_that_refuses(self, sample, cache):
        with served(b"gone", status=404) as address:
            sample(self.SAMPLE, address)
            fails(cache, "the server answers 404", HTTP)

    def test_no_server(self, sample, cache):
        sample(self.SAMPLE, "http://127.0.0.1:9/SampleData.zip")
        fails(cache, "is there a network", HTTP)

    def test_no_archive(self, sample, cache):
        with served(b"not a zip file") as address:
            sample(b"not a zip file", address)
            fails(cache, "cannot be unpacked", HTTP)

    @pytest.mark.parametrize("name", ["../T.csv", "a/../../T.csv", "/T.csv", "a\\..\\T.csv"])
    def test_a_path_outside(self, sample, cache, name):
        content = archive({name: b"1"})
        with served(content) as address:
            sample(content, address)
            fails(cache, "names a path outside", HTTP)
