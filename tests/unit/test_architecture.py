"""The house keeps its order: data flows one way, and the core needs no extras."""

import ast
import gc
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import semiwear

PACKAGE = Path(semiwear.__file__).parent
ROOT = PACKAGE.parent

# From the first to the last: a room may import itself and the rooms before it (design, section 2).
# `references` holds published figures; `check` is passed into scene/, so that scene/ needs no geometry.
LAYERS = (
    ("argument_ranges", "arrays", "errors", "untyped", "plain_text", "html_text"),
    ("references",),
    ("targets", "sources", "kernel_cache", "kept_on_disk", "threads", "closed_forms"),
    ("kernel_list", "own_python"),
    ("compile_ahead",),
    ("scene",),
    ("geometry",),
    ("meshing",),
    ("compliance",),
    ("contact",),
    ("wear",),
    ("ratings",),
    ("results", "check", "effect_clock", "observers"),
    ("plan", "collect"),
    ("life", "error_peaks"),
    ("simulate",),
    ("analyses", "citing", "screen_ratings", "loading", "measured_load", "rexs"),
    ("screen",),
    ("measured",),
    ("plot", "export"),
    ("report", "sweep", "accuracy", "emulator"),
    ("scatter",),
    ("optimise",),
    ("inference",),
    ("sensitivities",),
    ("__init__",),
    ("cli_values", "console", "completion", "commands"),
    ("cli",),
    ("__main__",),
)
RANK = {room: rank for rank, rooms in enumerate(LAYERS) for room in rooms}

EXTRAS = (
    "matplotlib",
    "mpl_toolkits",
    "plotly",
    "tqdm",
    "pypardiso",
    "dask",
    "distributed",
    "zarr",
    "rainflow",
    "meshio",
    "pyvista",
    "openpyxl",
    "shtab",
    "emcee",
    "sklearn",
)


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def parsed(path: Path) -> ast.Module:
    """The tree of a file; collecting garbage among so many nodes would take twice the time of making them."""
    gc.disable()
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    finally:
        gc.enable()


@cache
def nodes(path: Path) -> list[ast.AST]:
    """Every node of a file, those outside before those within: many tests look through all of them."""
    return list(ast.walk(parsed(path)))


def trees() -> dict[str, ast.Module]:
    """Every module of semiwear, by name."""
    return {name: parsed(path) for name, path in MODULES.items()}


def imported(node: ast.AST, module: str) -> list[str]:
    """Modules (or names in them) that an import statement asks for."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if not isinstance(node, ast.ImportFrom):
        return []
    base = node.module or ""
    if node.level:
        package = module if MODULES.get(module, Path()).name == "__init__.py" else module.rpartition(".")[0]
        for _ in range(node.level - 1):
            package = package.rpartition(".")[0]
        base = f"{package}.{base}".rstrip(".")
    return [f"{base}.{alias.name}" for alias in node.names]


@cache
def imports_of(module: str) -> frozenset[str]:
    """Every import of a module, inside functions and under TYPE_CHECKING as well."""
    return frozenset(name for node in nodes(MODULES[module]) for name in imported(node, module))


@cache
def imported_at_once(module: str) -> frozenset[str]:
    """Imports that run when the module is imported: not in functions, not under TYPE_CHECKING."""
    nodes: list[ast.AST] = [parsed(MODULES[module])]
    found: set[str] = set()
    while nodes:
        node = nodes.pop()
        found.update(imported(node, module))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        children = list(ast.iter_child_nodes(node))
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            children = node.orelse
        nodes += children
    return frozenset(found)


def own_module(name: str) -> str | None:
    """The semiwear module that an imported name lies in."""
    while name.startswith("semiwear"):
        if name in MODULES:
            return name
        name = name.rpartition(".")[0]
    return None


def room(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


@cache
def edges() -> dict[str, set[str]]:
    """Modules of semiwear that each of them imports."""
    return {
        name: {target for found in imports_of(name) if (target := own_module(found)) and target != name}
        for name in MODULES
    }


def test_the_test_sees_the_imports():
    assert len(MODULES) > 40
    assert "semiwear.scene.placement" in edges()["semiwear.scene"]
    assert "semiwear.meshing.flank_pair" in edges()["semiwear.plan"]
    assert sum(map(len, edges().values())) > 100


def test_every_room_has_its_place():
    assert {room(name) for name in MODULES} <= set(RANK)


def test_no_import_runs_back():
    assert not [
        f"{module} -> {target}"
        for module, targets in edges().items()
        for target in targets
        if RANK[room(target)] > RANK[room(module)]
    ]


def test_no_circle_of_imports():
    try:
        TopologicalSorter(edges()).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(reversed(error.args[1])))


def handed_on(tree):
    """Names that a module lists for others."""
    lists = [
        node.value for node in tree.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    return {name for names in lists for name in ast.literal_eval(names)}


def test_an_underscore_alone_says_what_is_private():
    """A list of public names stands only where a module hands on those of others."""
    assert not [
        f"{module} imports {name}"
        for module in MODULES
        for name in imports_of(module)
        if name.startswith("semiwear") and name.rpartition(".")[2].startswith("_") and not name.endswith("__")
    ]
    for module, tree in trees().items():
        if (names := handed_on(tree)) and MODULES[module].name != "__init__.py":
            assert names & {name.rpartition(".")[2] for name in imports_of(module)}, module


# Modules that load others of semiwear when they are needed: the plan loads an effect's physics only where a scene
# asks for it, public names (SPEC 1), commands and limits of a kind of teeth wait until they are used, and vectors of
# numbers may be what numba does not take.
LATE = {
    "semiwear",
    "semiwear.check",
    "semiwear.check.margins",
    "semiwear.cli",
    "semiwear.contact",
    "semiwear.kernel_list",
    "semiwear.plan",
    "semiwear.plan.effects",
    "semiwear.plan.ratings",
    "semiwear.compliance.lanes",
    "semiwear.meshing.flank_deviations",
}


def loads_late(path):
    """Whether a module imports another one of semiwear inside a function, by statement or by name."""
    within: set[ast.AST] = set()
    for node in nodes(path):
        if node in within or isinstance(node, ast.FunctionDef):
            within.update(ast.iter_child_nodes(node))
    by_name = any(isinstance(one, ast.Call) and getattr(one.func, "id", "") == "import_module" for one in within)
    return by_name or any(own_module(name) for node in within for name in imported(node, "semiwear"))


def test_own_modules_are_imported_at_the_top():
    assert {name for name, path in MODULES.items() if loads_late(path)} == LATE


@pytest.mark.slow
def test_public_names_are_found_in_any_order():
    code = """
import semiwear.plan, semiwear.report, semiwear.simulate, semiwear.screen, semiwear.sweep, semiwear.optimise
import semiwear as sw
for name in dir(sw):
    assert getattr(sw, name) is not None
assert all(callable(getattr(sw, name)) for name in sw.__all__ if name != "plot")
assert sw.contact.solve_half_space and sw.wear.wear_per_mesh and sw.geometry.involute
try:
    sw.nothing
except AttributeError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "module 'semiwear' has no attribute 'nothing'", done.stderr


# What must start at once does not load what computes. One process tries all in this order: what one of them loads
# stays loaded for those after it.
QUICK = {
    "import semiwear; semiwear.__version__": ("numpy", "numba", "xarray"),
    "from semiwear.cli import main; main(['--help'])": ("numpy", "numba", "xarray"),
    "from semiwear.cli import main; main(['run', 'face_gear_25x160', '--set', 'operation.pinion_torque_Nm=-1'])": (
        "numba",
        "xarray",
        "scipy",
    ),
    "import semiwear as sw; str(sw.plan(sw.load_scene('face_gear_25x160')))": (
        "matplotlib",
        "netCDF4",
        "tqdm",
        "xarray",
        "semiwear.contact.patch_contact",
    ),
    "from semiwear.commands import simulation": ("matplotlib", "sklearn", "semiwear.sweep", "semiwear.plot"),
    # scipy loads its submodule stats when `scipy.stats` is used
    "from semiwear.commands import sweep": (
        "matplotlib",
        "netCDF4",
        "sklearn",
        "scipy.stats",
        "semiwear.inference",
        "semiwear.optimise",
    ),
}


def test_what_starts_at_once_loads_little():
    code = f"""
import sys
for code, heavy in {QUICK!r}.items():
    try:
        exec(code)
    except SystemExit:
        pass
    print("LOADED", *sys.modules.keys() & set(heavy))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    told = [line for line in done.stdout.splitlines() if line.startswith("LOADED")]
    assert told == len(QUICK) * ["LOADED"], done.stdout + done.stderr


# Exports whole teeth and input decks: it takes meshes from there, never an answer.
MESHES = "semiwear.export.whole_teeth"


def test_nothing_computes_with_the_finite_element_reference():
    found = {
        module: names
        for module in MODULES
        if (names := {name for name in imports_of(module) if name.split(".")[0] == "fem_reference"})
    }
    assert set(found) == {MESHES}
    assert all(name.startswith(("fem_reference.worn_meshes", "fem_reference.tooth_mesh")) for name in found[MESHES])
    assert not {name for name in imported_at_once(MESHES) if name.startswith("fem_reference")}


FINITE_ELEMENTS = sorted((ROOT / "fem_reference").glob("*.py"))
LIBRARIES = {"numpy", "scipy", "skfem", "xarray", "fem_reference", "pypardiso"}
OURS = ("semiwear.scene", "semiwear.geometry", "semiwear.results", "semiwear.errors", "semiwear.contact.active_set")


@pytest.mark.parametrize("path", FINITE_ELEMENTS, ids=lambda path: path.stem)
def test_the_finite_element_reference_stands_on_its_own(path):
    """It judges contact, compliance and wear, so it must not borrow from them.

    The active set is no physics: a solution of its problem is unique, and is tested against least squares.
    """
    found = {name for node in nodes(path) for name in imported(node, "")}
    foreign = {name for name in found if name.split(".")[0] not in LIBRARIES | set(sys.stdlib_module_names)}
    assert not {name for name in foreign if not name.startswith(OURS)}


def test_extras_are_imported_where_they_are_used():
    assert not [
        f"{module}: {name}" for module in MODULES for name in imported_at_once(module) if name.split(".")[0] in EXTRAS
    ]


@pytest.mark.slow
def test_the_core_runs_without_extras():
    code = f"""
import sys
for name in {EXTRAS!r}:
    sys.modules[name] = None
import semiwear
import semiwear.simulate, semiwear.analyses, semiwear.plan, semiwear.collect, semiwear.results
scene = semiwear.load_scene("face_gear_25x160")
small = scene.replace({{
    "numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.profile_points": 31,
    "numerics.harmonics": 3, "wear.until.meshes": 1e8, "numerics.wear_steps": 1,
}})
tree = semiwear.simulate(small)
print(float(tree["flank"].wear_depth.max()) > 0.0)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=100, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "True"


_KINDS = (
    "face_gear", "face gear", "face-gear", "facegear", "cylindrical", "helical", "flank_points", "flankpoints",
    "point_flank", "pointflank", "hypoid", "bevel", "worm gear",
)  # fmt: skip


@pytest.mark.parametrize("folder", ["contact", "wear", "compliance"])
def test_contact_and_wear_know_no_kind_of_gear(folder):
    files = sorted((PACKAGE / folder).rglob("*.py"))
    assert files
    for path in files:
        text = path.read_text(encoding="utf-8").casefold()
        for word in _KINDS:
            assert word not in text, f"{path.relative_to(ROOT)}: {word}"


def test_tests_import_nothing_of_validation():
    """The core's tests stand without the pages that compare it with others; these have tests of their own."""
    for path in sorted((ROOT / "tests").rglob("*.py")):
        if "validation" in path.read_text(encoding="utf-8"):  # few: most need not be parsed
            for node in ast.walk(parsed(path)):
                assert not any(name.split(".")[0] == "validation" for name in imported(node, "")), path


def with_reference() -> list[tuple[str, Path]]:
    """Modules of semiwear and of the finite elements, by name."""
    return [*MODULES.items(), *((path.stem, path) for path in FINITE_ELEMENTS)]


def functions() -> list[tuple[str, ast.FunctionDef]]:
    return [
        (name, node) for name, path in with_reference() for node in nodes(path) if isinstance(node, ast.FunctionDef)
    ]


def test_functions_take_few_parameters():
    """Twelve, and fourteen where they are compiled: what belongs together goes in as one."""
    many = []
    for module, node in functions():
        count = len(node.args.posonlyargs) + len(node.args.args) + len(node.args.kwonlyargs)
        compiled = any("njit" in ast.unparse(how) or "_kernel" in ast.unparse(how) for how in node.decorator_list)
        if count > (14 if compiled else 12):
            many.append(f"{module}.{node.name}: {count}")
    assert not many


def test_what_has_no_type_has_a_name():
    """`Any` stands where its reason does: in `semiwear.untyped`, and where another library leaves no choice."""
    paths = [*PACKAGE.rglob("*.py"), *(ROOT / "fem_reference").rglob("*.py")]
    uses = {
        path.relative_to(ROOT).as_posix(): sum(
            isinstance(node, ast.Name) and node.id == "Any" for node in nodes(path)
        )
        for path in paths
    }
    assert {path: count for path, count in uses.items() if count} == {
        "semiwear/untyped.py": 3,
        "semiwear/__init__.py": 1,
        "semiwear/plot/style.py": 1,
    }


def test_docstrings_open_with_what_a_thing_is():
    """Or returns; "What it does ..." is no noun that a reader could look for."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    opening = [
        f"{name}: {text.splitlines()[0]}"
        for name, path in with_reference()
        for node in nodes(path)
        if isinstance(node, documented) and (text := ast.get_docstring(node)) and text.startswith("What ")
    ]
    assert not opening
