// A small valid scene in which no array is empty: two meshes, one of them skinned, morphed and animated.
#pragma once

#include "renderer/scene/flat_scene.h"

namespace halfshade {

inline FlatScene MakeEveryArrayScene() {
  FlatScene scene;
  scene.positions = {{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}, {-1, 0, -1}, {1, 0, -1}, {0, 0, 1}};
  scene.normals.assign(6, {0, 1, 0});
  scene.texcoords.assign(6, {.5f, .25f});
  scene.texcoords1.assign(6, {.125f, 1});
  scene.tangents.assign(6, {1, 0, 0, -1});
  scene.colors.assign(6, {1, .5f, 0, 1});
  scene.indices = {0, 1, 2, 0, 1, 2};
  for (uint32_t m = 0; m < 2; ++m) {
    Mesh mesh;
    mesh.origin = {m, 0, 0};
    mesh.first_vertex = mesh.first_index = 3 * m;
    mesh.vertex_count = mesh.index_count = 3;
    mesh.first_cluster = m;
    mesh.cluster_count = 1;
    mesh.bounds.Add({-1, 0, -1});
    mesh.bounds.Add({1, 0, 1});
    scene.meshes.push_back(mesh);
    scene.clusters.push_back({0, 1, mesh.bounds});
  }
  scene.images.push_back({"picture", "bytes", 4, 2});
  scene.textures.push_back({0, Wrap::kClampToEdge, Wrap::kMirroredRepeat, true, false, MipFilter::kNearest});
  scene.materials.resize(1);
  scene.materials[0].name = "leaf";
  scene.materials[0].base_color_texture = {0, 1};
  scene.materials[0].alpha_mode = AlphaMode::kMask;
  scene.materials[0].is_double_sided = true;
  scene.nodes.resize(3);
  scene.nodes[0].name = "root";
  scene.nodes[0].mesh_count = 1;
  scene.nodes[0].camera = 0;
  scene.nodes[0].place_count = 2;
  scene.nodes[1].parent = 0;
  scene.nodes[1].first_mesh = 1;
  scene.nodes[1].mesh_count = 1;
  scene.nodes[1].skin = 0;
  scene.nodes[1].weight_count = 1;
  scene.nodes[2].parent = 1;
  scene.cameras.push_back({"eye", false, 1, 0, .1, 100});
  scene.scenes = {{"all", {0}}};
  scene.places = {{{1, 2, 3}, {1, 0, 0, 0}, {1, 1, 1}}, {{4, 5, 6}, {1, 0, 0, 0}, {2, 2, 2}}};
  scene.morph_weights = {.5f};
  scene.skins.push_back({0, 1});
  scene.skin_joints = {2};
  scene.joint_from_mesh = {glm::mat4(1)};
  Deformed deformed;
  deformed.node = deformed.mesh = 1;
  deformed.bind_index_count = 3;
  deformed.influence_count = deformed.target_count = 1;
  scene.deformed = {deformed};
  for (int i = 0; i < 3; ++i) scene.bind_vertices.push_back({scene.positions[i], {0, 1, 0}, {1, 0, 0, 1}});
  scene.bind_indices = {0, 1, 2};
  scene.influences.assign(3, {0, 1});
  scene.morph_deltas.resize(3);
  scene.animations.push_back({"turn", 0, 2, 1});
  AnimationChannel turn;
  turn.node = 2;
  turn.path = AnimatedPath::kRotation;
  turn.key_count = 2;
  turn.width = 4;
  AnimationChannel grow;
  grow.node = 1;
  grow.path = AnimatedPath::kWeights;
  grow.interpolation = Interpolation::kCubic;
  grow.key_count = 2;
  grow.first_value = 8;
  grow.width = 1;
  scene.channels = {turn, grow};
  scene.animation_times = {0, 1};
  scene.animation_values = {0, 0, 0, 1, 0, 1, 0, 0, 0, .5f, 0, 0, 1, 0};
  scene.rests.resize(2);
  scene.rests[0].node = 1;
  scene.rests[1].node = 2;
  scene.warnings = {"/: a word"};
  scene.degenerate_triangles_dropped = 7;
  return scene;
}

}  // namespace halfshade
