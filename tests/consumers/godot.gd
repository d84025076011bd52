# What godot.mjs runs inside Godot 4: loads each model of the pack, looks at it from several sides,
# and tells the page what it saw.
extends Node3D

const SIDE := 384

var camera := Camera3D.new()


func _ready() -> void:
	get_window().size = Vector2i(SIDE, SIDE)
	var light := DirectionalLight3D.new()
	light.rotation_degrees = Vector3(-50, 30, 0)
	add_child(light)
	var environment := Environment.new()
	environment.background_mode = Environment.BG_COLOR
	environment.background_color = Color(0.45, 0.5, 0.6)
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_COLOR
	environment.ambient_light_color = Color(0.7, 0.75, 0.8)
	environment.ambient_light_energy = 0.7
	camera.environment = environment
	add_child(camera)
	camera.current = true
	var report := []
	for model in JSON.parse_string(FileAccess.get_file_as_string("res://models.json")):
		if model.has("impostor"):
			report.append(await look(model, impostor(model)))
		else:
			report.append(await look(model, loaded(model)))
	tell("/report", JSON.stringify(report))


func loaded(model: Dictionary) -> Node3D:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	if document.append_from_file("res://" + model.file, state) != OK:
		return null
	return document.generate_scene(state)


# The picture of the impostor's frames on its quad, with the sample shader that was exported.
func impostor(model: Dictionary) -> Node3D:
	var material := ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = FileAccess.get_file_as_string("res://" + model.shader)
	for uniform in ["albedo", "normal"]:
		var image := Image.new()
		image.load_png_from_buffer(FileAccess.get_file_as_bytes("res://" + model.files[uniform]))
		image.generate_mipmaps()
		material.set_shader_parameter(uniform + "_atlas", ImageTexture.create_from_image(image))
	var values: Dictionary = model.impostor
	material.set_shader_parameter("frames", int(values.frames))
	material.set_shader_parameter("full_sphere", values.form == "full")
	var center: Array = values.center_m
	material.set_shader_parameter("center_m", Vector3(center[0], center[1], center[2]))
	material.set_shader_parameter("half_m", values.half_m)
	material.set_shader_parameter("depth_m", values.depth_m)
	var quad := MeshInstance3D.new()
	quad.mesh = QuadMesh.new()
	quad.mesh.material = material
	var half := Vector3(model.size[0] / 2, model.size[1] / 2, model.size[2] / 2)
	quad.custom_aabb = AABB(Vector3(-half.x, 0, -half.z), half * 2)
	return quad


func look(model: Dictionary, scene: Node3D) -> Dictionary:
	if scene == null:
		return {"name": model.name, "error": "does not load"}
	add_child(scene)
	var box := bounds(scene)
	var views := {"front": [0, 0], "side": [90, 0], "back": [180, 0], "above": [30, 50]}
	var coverage := {}
	for view in views:
		var far: bool = model.get("is_scene", false)
		coverage[view] = await taken(model.name + "_" + view, box, views[view], 1.0)
		if far:
			break
	if not model.get("is_scene", false):
		coverage["far"] = await taken(model.name + "_far", box, [0, 0], 12.0)
	var textures := formats(scene)
	remove_child(scene)
	scene.queue_free()
	return {
		"name": model.name, "foot": box.position.y, "height": box.size.y, "width": box.size.x,
		"coverage": coverage, "textures": textures, "kind": model.kind,
	}


# A picture from a direction; the share of the tree's own square on it that shows the tree.
func taken(title: String, box: AABB, angles: Array, away: float) -> float:
	var reach: float = maxf(box.size.length(), 0.1)
	camera.fov = 30
	var distance := away * reach / 2.0 / tan(deg_to_rad(15))
	var turn := Basis.from_euler(Vector3(-deg_to_rad(angles[1]), deg_to_rad(angles[0]), 0))
	camera.position = box.get_center() + turn * Vector3(0, 0, distance)
	camera.basis = turn
	camera.near = distance / 100
	camera.far = distance + reach * 4
	for frame in 3:
		await RenderingServer.frame_post_draw
	var image := get_viewport().get_texture().get_image()
	tell("/picture/" + title, Marshalls.raw_to_base64(image.save_png_to_buffer()))
	var empty := image.get_pixel(0, 0)
	var count := 0
	for y in image.get_height():
		for x in image.get_width():
			var pixel := image.get_pixel(x, y)
			var apart := absf(pixel.r - empty.r) + absf(pixel.g - empty.g) + absf(pixel.b - empty.b)
			if apart > 0.06:
				count += 1
	return count * away * away / float(image.get_width() * image.get_height())


func bounds(scene: Node3D) -> AABB:
	var box := AABB()
	var first := true
	var shown := scene.find_children("*", "VisualInstance3D", true, false)
	if scene is VisualInstance3D:
		shown.append(scene)
	for node in shown:
		var own: AABB = node.global_transform * node.get_aabb()
		if node is MeshInstance3D and node.custom_aabb.has_volume():
			own = node.global_transform * node.custom_aabb
		box = own if first else box.merge(own)
		first = false
	return box


# The formats that the textures of a scene have on the card.
func formats(scene: Node3D) -> Array:
	var found := {}
	for node in scene.find_children("*", "MeshInstance3D", true, false):
		for surface in node.mesh.get_surface_count():
			var material = node.mesh.surface_get_material(surface)
			if material is BaseMaterial3D and material.albedo_texture:
				var image: Image = material.albedo_texture.get_image()
				if image:
					var mips := " with mips" if image.has_mipmaps() else ""
					found[str(image.get_format()) + mips] = true
	return found.keys()


func tell(where: String, text: String) -> void:
	JavaScriptBridge.eval("window.tell(%s, %s)" % [JSON.stringify(where), JSON.stringify(text)])
