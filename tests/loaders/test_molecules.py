"""Molecules: which atoms are drawn, where, how large, in which colour; and what broken files are told."""

from __future__ import annotations

import gzip
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.loaders.read_options import MoleculeOptions

SCENES = Path(os.environ.get("SSAO_GL_SCENES", "shared/scenes"))
needs_scenes = pytest.mark.skipif(not (SCENES / "1m4x.cif").is_file(), reason="SSAO_GL_SCENES has no molecules")

ATOM = "ATOM  {n:>5} {name:<4}{alt}{res:<3} {chain}{seq:>4}    {x:8.3f}{y:8.3f}{z:8.3f}{occ:6.2f} 10.00          {el:>2}\n"


def atom(n: int, x: float, y: float = 0, z: float = 0, **more: Any) -> str:
    values = {"name": "CA", "alt": " ", "res": "ALA", "chain": "A", "seq": n, "occ": 1.0, "el": "C"} | more
    return ATOM.format(n=n, x=x, y=y, z=z, **values)


CIF = """data_x
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_entity_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.occupancy
_atom_site.auth_asym_id
_atom_site.auth_seq_id
_atom_site.pdbx_PDB_model_num
ATOM 1 N N . GLY A 1 1 0.0 0.0 0.0 1.0 X 1 1
ATOM 2 C CA . GLY B 1 1 3.0 0.0 0.0 1.0 X 2 1
HETATM 3 ZN ZN . ZN C 2 . {x} 4.0 0.0 1.0 Y 3 1
"""
ASSEMBLY = """loop_
_pdbx_struct_assembly_gen.assembly_id
_pdbx_struct_assembly_gen.oper_expression
_pdbx_struct_assembly_gen.asym_id_list
1 1 A
1 (1,m) B,C
loop_
_pdbx_struct_oper_list.id
_pdbx_struct_oper_list.matrix[1][1]
_pdbx_struct_oper_list.matrix[1][2]
_pdbx_struct_oper_list.matrix[1][3]
_pdbx_struct_oper_list.vector[1]
_pdbx_struct_oper_list.matrix[2][1]
_pdbx_struct_oper_list.matrix[2][2]
_pdbx_struct_oper_list.matrix[2][3]
_pdbx_struct_oper_list.vector[2]
_pdbx_struct_oper_list.matrix[3][1]
_pdbx_struct_oper_list.matrix[3][2]
_pdbx_struct_oper_list.matrix[3][3]
_pdbx_struct_oper_list.vector[3]
1 1 0 0 0 0 1 0 0 0 0 1 0
m 0 -1 0 10 1 0 0 0 0 0 1 0
"""


def read(folder: Path, text: str, name: str = "a.pdb", **options: Any) -> ao.Scene:
    (folder / name).write_text(text)
    return ao.load_scene(folder / name, molecule=MoleculeOptions(**options))


def world(scene: ao.Scene) -> np.ndarray:
    parts = [m[:3, :3] @ c + m[:3, 3] for one in scene.spheres for m in one.transforms for c in one.centers.astype(float)]
    return np.array(parts)


def test_radii_are_van_der_waals(tmp_path: Path) -> None:
    text = "".join(atom(n, 4 * n, el=el, name=el) for n, el in enumerate(("H", "C", "N", "O", "S", "P", "FE", "X"), 1))
    (found,) = read(tmp_path, text).spheres
    np.testing.assert_allclose(found.radii[[0, 1, 2, 3, 4, 5, 7]], [1.10, 1.70, 1.55, 1.52, 1.80, 1.80, 1.70], rtol=1e-6)
    assert 1.2 < found.radii[6] < 2.6
    (larger,) = read(tmp_path, text, radius_scale=2.0).spheres
    np.testing.assert_allclose(larger.radii, 2 * found.radii)


def test_water_and_hydrogens(tmp_path: Path) -> None:
    text = atom(1, 0) + atom(2, 3, el="H", name="H") + atom(3, 6, el="O", name="O", res="HOH")
    assert len(world(read(tmp_path, text))) == 2
    assert len(world(read(tmp_path, text, water=True))) == 3
    assert len(world(read(tmp_path, text, water=True, hydrogens=False))) == 2
    with pytest.raises(ao.SceneError, match="no atoms but water; add --water"):
        read(tmp_path, atom(3, 6, el="O", name="O", res="HOH"))


def test_of_alternatives_the_likeliest_is_drawn(tmp_path: Path) -> None:
    text = atom(1, 0, alt="A", occ=0.3, seq=1) + atom(2, 1, alt="B", occ=0.7, seq=1)
    text += atom(3, 5, alt="B", occ=0.5, seq=2) + atom(4, 6, alt="A", occ=0.5, seq=2) + atom(5, 9, seq=3)
    np.testing.assert_allclose(world(read(tmp_path, text))[:, 0], [1, 6, 9], atol=1e-5)


def test_models(tmp_path: Path) -> None:
    text = "MODEL        1\n" + atom(1, 0) + "ENDMDL\nMODEL        2\n" + atom(1, 7) + "ENDMDL\n"
    scene = read(tmp_path, text)
    assert world(scene)[0, 0] == 0 and "2 models; model 1 is drawn" in scene.warnings[0]
    assert world(read(tmp_path, text, model=2))[0, 0] == 7
    with pytest.raises(ao.SceneError, match="no model 3; it has: 1, 2"):
        read(tmp_path, text, model=3)


def test_assembly_of_a_cif(tmp_path: Path) -> None:
    """Two rows for one assembly: A once, B and C at two places."""
    scene = read(tmp_path, CIF.format(x=0.0) + ASSEMBLY, "a.cif", assembly="1")
    assert scene.pieces == 5
    expected = [[0, 0, 0], [3, 0, 0], [0, 4, 0], [10, 3, 0], [6, 0, 0]]
    assert sorted(map(tuple, np.round(world(scene), 4).tolist())) == sorted(map(tuple, np.float64(expected).tolist()))
    assert read(tmp_path, CIF.format(x=0.0) + ASSEMBLY, "a.cif").pieces == 3
    with pytest.raises(ao.SceneError, match=r"no assembly '2'; it has: 1 \(5 atoms\)"):
        read(tmp_path, CIF.format(x=0.0) + ASSEMBLY, "a.cif", assembly="2")
    with pytest.raises(ao.SceneError, match="no assembly '1'; it has: none"):
        read(tmp_path, CIF.format(x=0.0), "a.cif", assembly="1")


@pytest.mark.parametrize(
    ("by", "groups"), [("element", [0, 1, 2]), ("chain", [0, 0, 1]), ("asym", [0, 1, 2]), ("entity", [0, 0, 1])]
)
def test_colors(by: str, groups: list[int], tmp_path: Path) -> None:
    (found,) = read(tmp_path, CIF.format(x=0.0), "a.cif", color=by).spheres
    assert found.colors is not None
    distinct = {tuple(c) for c in found.colors.tolist()}
    assert len(distinct) == len(set(groups))
    assert [found.colors.tolist().index(c) for c in found.colors.tolist()] == [groups.index(g) for g in groups]


def test_packed_and_misnamed_files(tmp_path: Path) -> None:
    text = CIF.format(x=0.0)
    (tmp_path / "a.cif.gz").write_bytes(gzip.compress(text.encode()))
    assert ao.load_scene(tmp_path / "a.cif.gz").pieces == 3
    assert read(tmp_path, text, "b.pdb").pieces == 3
    assert read(tmp_path, atom(1, 0), "c.cif").pieces == 1
    (tmp_path / "bomb.pdb.gz").write_bytes(gzip.compress(bytes(64 << 20)))
    with pytest.raises(ao.SceneError, match="more than 32 times its size"):
        ao.load_scene(tmp_path / "bomb.pdb.gz")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.cif", "data_x\n_cell.length_a 5\n", "holds no atoms with coordinates"),
        ("a.cif", CIF.format(x=0.0) + "loop_\n_a.b\n_a.c\n1 2 3\n", r"line \d+"),
        ("a.pdb", "hello\n", "holds no atoms"),
        ("a.bcif", "x", "BinaryCIF is not read"),
        ("a.cif", "version https://git-lfs.github.com/spec/v1\n", "Git LFS"),
        ("a.pdb", atom(1, 0).replace("   0.000", "     abc"), "none of its atoms has coordinates"),
    ],
)
def test_what_is_broken_is_told_in_a_line(name: str, text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(ao.SceneError, match=told) as error:
        read(tmp_path, text, name)
    assert "\n" not in str(error.value)


def test_atoms_without_place_are_left_out(tmp_path: Path) -> None:
    scene = read(tmp_path, CIF.format(x="?"), "a.cif")
    assert scene.pieces == 2 and "1 atoms are left out" in scene.warnings[0] and "atom 3" in scene.warnings[0]
    scene = read(tmp_path, atom(1, 0) + atom(2, 5).replace("   5.000", "     abc") + atom(3, 9), "a.pdb")
    assert scene.pieces == 2 and "1 atoms are left out" in scene.warnings[0] and "line 2" in scene.warnings[0]
    with pytest.raises(ao.SceneError, match="no asym ids to colour by"):
        read(tmp_path, atom(1, 0), color="asym")


@needs_scenes
@pytest.mark.parametrize(
    ("assembly", "atoms"),
    [("1", 16_284_240), ("2", 271_404), ("3", 1_357_020), ("4", 1_628_424), ("5", 290_790), ("6", 639_738)],
)
def test_capsid(assembly: str, atoms: int) -> None:
    scene = ao.load_scene(SCENES / "1m4x.cif", molecule=MoleculeOptions(assembly=assembly))
    assert scene.pieces == atoms and sum(len(one.centers) for one in scene.spheres) == 9_693
    assert scene.contents == f"{atoms:,} spheres"


@needs_scenes
def test_files_of_the_archive() -> None:
    assert ao.load_scene(SCENES / "1cbs.cif", molecule=MoleculeOptions(water=True)).pieces == 1_213
    assert ao.load_scene(SCENES / "1igy.pdb", molecule=MoleculeOptions(assembly="1")).pieces == 12_750
