"""check.py ORIGINAL COPY ...: Blender finds as much of each kind in a copy as in its original. Exit code 1 if not."""

import os
import sys

import bpy

COLLECTIONS = ("objects", "meshes", "materials", "lights", "cameras", "armatures", "actions", "images", "shape_keys")


def counts(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path))
    found = {name: len(getattr(bpy.data, name)) for name in COLLECTIONS}
    found["bones"] = sum(len(armature.bones) for armature in bpy.data.armatures)
    found["vertices"] = sum(len(mesh.vertices) for mesh in bpy.data.meshes)
    return found


def main(paths):
    failures = 0
    for original, copy in zip(paths[::2], paths[1::2]):
        before, after = counts(original), counts(copy)
        if not before["objects"] or before != after:
            print(f"{copy}: Blender finds {after}, in {original} {before}")
            failures += 1
    print(f"{len(paths) // 2} files, {failures} failures")
    return 1 if failures else 0


arguments, sys.argv = sys.argv[1:], sys.argv[:1]  # Blender would read them, too
sys.exit(main(arguments))
