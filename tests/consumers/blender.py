"""Imports every GLB of an exported folder into Blender and renders it.

    pip install bpy
    python blender.py FOLDER OUT [NAME …]

Fails when a tree does not stand on the ground, has another height than library.json says, or has no
wind weights. Writes OUT/NAME.png, rendered by Cycles with its own defaults from a low camera, to be
looked at; of a crown also OUT/NAME_surface.png.
"""
import json
import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def bounds(objects):
    corners = [o.matrix_world @ Vector(c) for o in objects if o.type == "MESH" for c in o.bound_box]
    return [min(c[i] for c in corners) for i in range(3)], [max(c[i] for c in corners) for i in range(3)]


def render(path, height, distance):
    scene = bpy.context.scene
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.55, 0.7, 0.9, 1)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 3
    sun.rotation_euler = (math.radians(50), 0, math.radians(40))
    bpy.ops.mesh.primitive_plane_add(size=200)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.35 * distance, -distance, 0.55 * height)
    camera.rotation_euler = (Vector((0, 0, 0.48 * height)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    for thing in (sun, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 8
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 480, 480
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def check(model, name, height, slack):
    """Imports `model` and hides all but its finest level; what is wrong with it."""
    empty_scene()
    bpy.ops.import_scene.gltf(filepath=str(model))
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    for o in meshes:
        o.hide_render = o.name.endswith(("_LOD1", "_LOD2", "_LOD3"))
    meshes = [o for o in meshes if not o.hide_render]
    least, most = bounds(meshes)
    failures = []
    if abs(least[2]) > 0.04 * height or abs(most[2] - height) > slack * height:
        failures.append(f"{name}: from {least[2]:.2f} to {most[2]:.2f} m, not 0 to {height:.2f}")
    if any("_WIND" not in o.data.attributes for o in meshes):
        failures.append(f"{name}: no wind weights")
    return failures


def main(folder, out, names):
    library = json.loads((folder / "library.json").read_text())
    out.mkdir(parents=True, exist_ok=True)
    failures = []
    for tree in library["trees"]:
        if names and tree["name"] not in names:
            continue
        height = (tree["pivot_px"][1] - tree["frame"]["y"]) * tree["metres_per_pixel"]
        failures += check(folder / tree["files"]["model"], tree["name"], height, 0.04)
        render(out / f"{tree['name']}.png", height, 2.6 * height)
    for crown in library.get("crowns", []):
        if names and crown["name"] not in names:
            continue
        height = crown["size_m"][1]
        for key, end in (("model", ""), ("surface", "_surface")):
            failures += check(folder / crown["files"][key], crown["name"] + end, height, 0.1)
            render(out / f"{crown['name']}{end}.png", height, 2.6 * height)
    if (folder / "scatter.glb").exists() and not names:
        empty_scene()
        bpy.ops.import_scene.gltf(filepath=str(folder / "scatter.glb"))
        render(out / "scatter.png", 10, 90)
    print("\n".join(failures) or "all trees stand as they should")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]))
