#!/usr/bin/python3
"""Opens meshes in headless Blender and MeshLab and compares the counts and bounds there with those of the files.

    scripts/check_in_viewers.py [--closed] FILE...

FILE: .glb, .gltf, .ply, .obj, .stl as isoextract writes them. For each file one row has the figures of the file itself,
which this script reads, and one row per program has those of the imported mesh. The figures are vertices, triangles,
edges of one triangle (open), edges of more than two (crossed), and bounds. Counts must be equal; bounds must be equal
to a float32, as both programs keep no more. --closed: an open or crossed edge is an error as well.

Meshes without connectivity (.stl, and glTF with flat normals) are compared after vertices at one place became one and
triangles that then have two equal corners were dropped: all three do it. Blender alone drops the second of two
triangles with the same corners as well, which is allowed for. Axes are those of the file: what Blender turns
on import of glTF is turned back.

Needs Debian's packages blender, meshlab, xvfb, xauth and python3-numpy, and runs with Debian's own python3. It is not
part of the test suite. MeshLab 2020.09 opens no glTF. Debian 12's build of it ends with a failed assertion on every
.obj, its own included; this is tried first with one triangle, and MeshLab's row then says that it did not take part.

Ends with 0 if all agree, 1 if not, 2 if a program is missing or nothing could be compared.
"""

import argparse
import dataclasses
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / 'viewers'))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'tests' / 'support'))

import mesh_readers  # noqa: E402
from mesh_facts import Facts, Mesh, measure, merged, without_repeats  # noqa: E402

BLENDER_SCRIPT = Path(__file__).resolve().parent / 'viewers' / 'blender_measure.py'
MESHLAB_FORMATS = {'.ply', '.obj', '.stl'}
TIMEOUT_SECONDS = 1800

MESHLAB_SCRIPT = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Compute Topological Measures"/>
</FilterScript>
"""


@dataclasses.dataclass
class Expected:
    """Facts of a file as this script reads it."""
    facts: Facts
    facts_in_blender: Facts
    has_connectivity: bool


def read(path):
    """The meshes of a file, and whether they have connectivity."""
    found = mesh_readers.read(path)
    meshes = [Mesh(np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3),
                   np.array(mesh.triangles, dtype=np.int64).reshape(-1, 3)) for mesh in found]
    return meshes, all(mesh.has_connectivity for mesh in found)


def expect(path):
    meshes, has_connectivity = read(path)
    if not has_connectivity:
        meshes = [merged(mesh) for mesh in meshes]
    return Expected(measure(meshes), measure([without_repeats(mesh) for mesh in meshes]), has_connectivity)


def ask_blender(expected):
    """Facts of all files from one run of Blender, by path."""
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / 'answer.json'
        jobs = [{'path': str(path), 'merge': not file.has_connectivity} for path, file in expected.items()]
        command = ['blender', '--background', '--factory-startup', '--python-exit-code', '1',
                   '--python', str(BLENDER_SCRIPT), '--', json.dumps(jobs), str(answer)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_SECONDS)
        if not answer.exists():
            sys.exit(f'Blender failed:\n{done.stdout}\n{done.stderr}')
        facts = json.loads(answer.read_text())
    return {path: Facts(**facts[str(path)]) if facts[str(path)] else None for path in expected}


def ask_meshlab(path):
    """Facts of one file, or None if MeshLab cannot open it. Edges are from its log, bounds from what it saves."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / 'measure.mlx'
        script.write_text(MESHLAB_SCRIPT)
        saved = Path(folder) / 'saved.ply'
        # Links the file under a plain name: MeshLab's command line accepts no others.
        link = Path(folder) / ('mesh' + path.suffix.lower())
        link.symlink_to(path.resolve())
        command = ['xvfb-run', '-a', 'meshlabserver', '-i', str(link), '-o', str(saved), '-s', str(script)]
        done = subprocess.run(command, capture_output=True, text=True, errors='replace', timeout=TIMEOUT_SECONDS)
        log = done.stdout + done.stderr
        open_edges = re.search(r'^Boundary Edges (\d+)', log, re.MULTILINE)
        if not saved.exists() or not open_edges:
            return None
        crossed = re.search(r'^Mesh has (\d+) non two manifold edges', log, re.MULTILINE)
        facts = measure(read(saved)[0])
        facts.open_edges = int(open_edges[1])
        facts.crossed_edges = int(crossed[1]) if crossed else 0
        return facts


def meshlab_opens_obj():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'one.obj'
        path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
        return ask_meshlab(path) is not None


def differences(expected, found):
    """Names of the facts that differ."""
    if found is None:
        return ['not opened']
    wrong = [name for name in ('vertices', 'triangles', 'open_edges', 'crossed_edges')
             if getattr(expected, name) != getattr(found, name)]
    # Both programs compute in float32: one step at the farthest coordinate; Blender adds the position of the object.
    farthest = max(map(abs, expected.minimum + expected.maximum))
    tolerance = 2.0 ** -23 * farthest
    if any(abs(a - b) > tolerance
           for a, b in zip(expected.minimum + expected.maximum, found.minimum + found.maximum)):
        wrong.append('bounds')
    return wrong


def print_row(name, who, facts, verdict):
    counts = [facts.vertices, facts.triangles, facts.open_edges, facts.crossed_edges] if facts else ['-'] * 4
    bounds = ['(' + ' '.join(f'{x:.7g}' for x in corner) + ')'
              for corner in ((facts.minimum, facts.maximum) if facts else ())]
    print(f'{name:28} {who:8}' + ''.join(f' {count:>9}' for count in counts) + f'  {" .. ".join(bounds)}  {verdict}')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--closed', action='store_true', help='an open or crossed edge is an error')
    parser.add_argument('files', nargs='+', type=Path, metavar='FILE')
    options = parser.parse_args()
    missing = [program for program in ('blender', 'meshlabserver', 'xvfb-run') if not shutil.which(program)]
    if missing:
        print(f'not installed: {", ".join(missing)}; apt-get install blender meshlab xvfb xauth', file=sys.stderr)
        return 2

    expected = {path: expect(path) for path in options.files}
    for path in [path for path, file in expected.items() if file.facts.triangles == 0]:
        print(f'{path.name}: no triangles, left out')
        del expected[path]
    if not expected:
        return 2
    blender = ask_blender(expected)
    opens_obj = any(path.suffix.lower() == '.obj' for path in expected) and meshlab_opens_obj()

    print(f'{"file":28} {"seen by":8} {"vertices":>9} {"triangles":>9} {"open":>9} {"crossed":>9}  bounds')
    good = True
    for path, file in expected.items():
        suffix = path.suffix.lower()
        closed = file.facts.open_edges == 0 and file.facts.crossed_edges == 0
        good = good and (closed or not options.closed)
        print_row(path.name, 'file', file.facts, '' if closed or not options.closed else 'NOT CLOSED')
        rows = [('blender', file.facts_in_blender, blender[path])]
        if suffix in MESHLAB_FORMATS and (suffix != '.obj' or opens_obj):
            rows.append(('meshlab', file.facts, ask_meshlab(path)))
        for who, facts, found in rows:
            wrong = differences(facts, found)
            good = good and not wrong
            print_row('', who, found, 'equal' if not wrong else 'DIFFERENT: ' + ', '.join(wrong))
        if suffix == '.obj' and not opens_obj:
            print_row('', 'meshlab', None, 'did not take part: it opens no .obj here')
    print('all equal' if good else 'NOT all equal')
    return 0 if good else 1


if __name__ == '__main__':
    sys.exit(main())
