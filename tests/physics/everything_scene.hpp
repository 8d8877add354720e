#pragma once

/// A scene with one of everything that a file can say, in JSON and in TOML.
inline constexpr const char* everything_json = R"({
  "format": "graphsolve-scene", "version": 1, "name": "all \"of it\" é",
  "time_step": 0.005, "gravity": [0, 0, -1.5], "start": "standard", "x_author": {"name": "me", "year": 2024},
  "bodies": [
    {"name": "ball", "mass": 2, "shape": {"type": "sphere", "radius": 0.5}, "x_color": "red"},
    {"name": "brick", "mass": 3, "inertia": [[1, 0.1, 0], [0.1, 2, 0], [0, 0, 2.5]],
     "shape": {"type": "box", "size": [1, 2, 3]}, "position": [0, 0, 4], "orientation": [0, 1, 0, 0],
     "velocity": [1, 2, 3], "angular_velocity": [4, 5, 6]},
    {"name": "can", "mass": 1, "shape": {"type": "cylinder", "radius": 0.1, "height": 0.2}},
    {"name": "pill", "mass": 1, "shape": {"type": "capsule", "radius": 0.1, "height": 0.2}},
    {"name": "cow", "mass": 1, "inertia": [1, 1, 1], "shape": {"type": "mesh", "file": "cow.obj"}}],
  "joints": [
    {"name": "a", "type": "fixed", "parent": "world", "child": "ball"},
    {"name": "b", "type": "revolute", "parent": "ball", "child": "brick", "axis": [1, 0, 0],
     "motor": {"stiffness": 1, "damping": 2, "limit": 3, "target": 0.25}},
    {"name": "c", "type": "prismatic", "parent": "brick", "child": "can", "axis": [0, 1, 0],
     "parent_point": [1, 2, 3], "child_point": [4, 5, 6], "orientation": [0, 0, 1, 0],
     "motor": {"stiffness": 1, "target": {"offset": 1, "amplitude": 2, "frequency": 3, "phase": 4}}},
    {"name": "d", "type": "spherical", "parent": "can", "child": "pill", "x_note": null},
    {"name": "e", "type": "revolute", "parent": "pill", "child": "cow", "axis": [0, 0, 1],
     "motor": {"damping": 1, "target": [[0, 1], [0.5, 2]]}}],
  "contacts": [
    {"name": "smooth", "body": "ball", "radius": 0.5},
    {"name": "rough", "body": "brick", "point": [1, 2, 3], "normal": [0, 1, 0], "plane_point": [0, -1, 0],
     "friction": 0.3, "friction_model": "pyramid", "directions": 6, "tangent": [1, 0, 0], "x_id": 17}],
  "loads": [{"body": "can", "steps": [2, 5], "force": [1, 0, 0], "torque": [0, 1, 0]}]
})";

inline constexpr const char* everything_toml = R"(
format = "graphsolve-scene"
version = 1
name = 'all "of it" é'
time_step = 0.005
gravity = [0, 0, -1.5]
start = "standard"
x_author = { name = "me", year = 2024 }

[[bodies]]
name = "ball"
mass = 2
shape = { type = "sphere", radius = 0.5 }
x_color = "red"

[[bodies]]
name = "brick"
mass = 3
inertia = [[1, 0.1, 0], [0.1, 2, 0], [0, 0, 2.5]]
shape = { type = "box", size = [1, 2, 3] }
position = [0, 0, 4]
orientation = [0, 1, 0, 0]
velocity = [1, 2, 3]
angular_velocity = [4, 5, 6]

[[bodies]]
name = "can"
mass = 1
shape = { type = "cylinder", radius = 0.1, height = 0.2 }

[[bodies]]
name = "pill"
mass = 1
[bodies.shape]
type = "capsule"
radius = 0.1
height = 0.2

[[bodies]]
name = "cow"
mass = 1.0
inertia = [1, 1, 1]
shape = { type = "mesh", file = "cow.obj" }

[[joints]]
name = "a"
type = "fixed"
parent = "world"
child = "ball"

[[joints]]
name = "b"
type = "revolute"
parent = "ball"
child = "brick"
axis = [1, 0, 0]
motor = { stiffness = 1, damping = 2, limit = 3, target = 0.25 }

[[joints]]
name = "c"
type = "prismatic"
parent = "brick"
child = "can"
axis = [0, 1, 0]
parent_point = [1, 2, 3]
child_point = [4, 5, 6]
orientation = [0, 0, 1, 0]
motor = { stiffness = 1, target = { offset = 1, amplitude = 2, frequency = 3, phase = 4 } }

[[joints]]
name = "d"
type = "spherical"
parent = "can"
child = "pill"

[[joints]]
name = "e"
type = "revolute"
parent = "pill"
child = "cow"
axis = [0, 0, 1]
[joints.motor]
damping = 1
target = [[0, 1], [0.5, 2]]

[[contacts]]
name = "smooth"
body = "ball"
radius = 0.5

[[contacts]]
name = "rough"
body = "brick"
point = [1, 2, 3]
normal = [0, 1, 0]
plane_point = [0, -1, 0]
friction = 0.3
friction_model = "pyramid"
directions = 6
tangent = [1, 0, 0]
x_id = 17

[[loads]]
body = "can"
steps = [2, 5]
force = [1, 0, 0]
torque = [0, 1, 0]
)";
