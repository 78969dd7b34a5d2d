#include "renderer/shade/gbuffer.h"

#include <glad/gl.h>

#include <algorithm>
#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <optional>
#include <tuple>

#include "renderer/gl/framebuffer.h"
#include "renderer/math/camera.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kMillisecondsPerTriangle = 3e-4;  // llvmpipe, two cores
constexpr double kMillisecondsPerPixel = 4e-5;     // cleared and covered a few times
constexpr uint32_t kTrianglesPerDraw = 32768;
constexpr size_t kObjectIdLocation = 7;  // of out_object_id in gbuffer.frag
constexpr GLuint kPlanesBinding = 0;
// The ground's colour: a neutral grey that shows shadow and light.
constexpr glm::vec4 kGroundColor{0.6f, 0.6f, 0.6f, 1};

// Texture units; bit i of second_texcoord (gbuffer.frag) is of unit i.
enum Unit { kBaseColorUnit, kMetallicRoughnessUnit, kNormalUnit, kOcclusionUnit, kEmissiveUnit, kMaskUnit, kUnits };

// What differs between instances: attributes from kFirstInstanceAttribute on (shade/gbuffer.vert).
struct InstanceAttributes {
  glm::mat4 clip_from_mesh;
  glm::mat3x4 camera_from_mesh;  // its rows; world axes, origin at the eye
  glm::mat3x4 normal_from_mesh;  // its columns; w: handedness, scale of planes, object id
  bool IsMirrored() const { return normal_from_mesh[0].w < 0; }
};
constexpr GLuint kFirstInstanceAttribute = 6;
constexpr size_t kMostInstances = 16384;  // held at a time: 2.6 MB

// Triangles of one mesh, and how those instances stand that are drawn together.
struct Drawable {
  const Material* material = nullptr;
  const MaterialTextures* textures = nullptr;  // null: none
  bool is_masked = false;
  bool is_mirrored = false;
  uint32_t first_triangle = 0;
  uint32_t triangle_count = 0;
  uint32_t base_vertex = 0;
};

void SetInstances(const gl::VertexArray& vertex_array, const gl::Buffer& instances) {
  constexpr GLuint kVectors = sizeof(InstanceAttributes) / sizeof(glm::vec4);
  const GladGLContext& gl = vertex_array.gl();
  const GLuint array = vertex_array.id();
  gl.VertexArrayVertexBuffer(array, kFirstInstanceAttribute, instances.id(), 0, sizeof(InstanceAttributes));
  gl.VertexArrayBindingDivisor(array, kFirstInstanceAttribute, 1);
  for (GLuint i = 0; i < kVectors; ++i) {
    const GLuint attribute = kFirstInstanceAttribute + i;
    gl.VertexArrayAttribFormat(array, attribute, 4, GL_FLOAT, GL_FALSE, i * GLuint(sizeof(glm::vec4)));
    gl.VertexArrayAttribBinding(array, attribute, kFirstInstanceAttribute);
    gl.EnableVertexArrayAttrib(array, attribute);
  }
}

Material GroundMaterial() {
  Material material;
  material.base_color = kGroundColor;
  material.metallic = 0;
  material.is_double_sided = true;
  return material;
}

class GBufferPass {
 public:
  GBufferPass(const DrawContext& draw, const RenderRequest& request, bool with_materials)
      : draw_(draw), gl_(draw.context->gl()), camera_(request.camera), with_materials_(with_materials) {
    const double aspect = double(request.width) / request.height;
    // Row 0 of the image is row 0 of the framebuffer: y is flipped here, and with it what counts as a front face.
    flipped_clip_from_camera_ = glm::dmat4(1);
    flipped_clip_from_camera_[1][1] = -1;
    flipped_clip_from_camera_ = flipped_clip_from_camera_ * ClipFromView(request.camera, aspect) *
                                glm::dmat4(ViewRotationFromWorld(request.camera));
    gl_.GetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &buffer_alignment_);
  }
  ~GBufferPass() {
    for (int unit = 0; unit < kUnits; ++unit) gl_.BindSampler(GLuint(unit), 0);
  }

  // None for what stands flattened: no triangle has an area.
  std::optional<InstanceAttributes> Attributes(const glm::dmat4& world_from_mesh, bool receives,
                                               uint32_t object_id) const {
    // Camera-relative: the large numbers cancel in double, before anything is rounded.
    glm::dmat4 camera_from_mesh = world_from_mesh;
    camera_from_mesh[3] -= glm::dvec4(camera_.eye_ws, 0);
    const glm::dmat3 linear(camera_from_mesh);
    const double determinant = glm::determinant(linear);
    if (determinant == 0) return std::nullopt;
    InstanceAttributes attributes;
    attributes.clip_from_mesh = glm::mat4(flipped_clip_from_camera_ * camera_from_mesh);
    attributes.camera_from_mesh = glm::mat3x4(glm::transpose(glm::mat4(camera_from_mesh)));
    attributes.normal_from_mesh = glm::mat3x4(glm::mat3(glm::transpose(glm::inverse(linear))));
    attributes.normal_from_mesh[0].w = determinant > 0 ? 1.0f : -1.0f;
    attributes.normal_from_mesh[1].w = receives ? 1.0f : kNotReceivingScale;
    attributes.normal_from_mesh[2].w = float(object_id);
    return attributes;
  }

  // Instances of the vertex array that is bound.
  absl::Status Draw(const Drawable& drawable, const gl::Buffer& planes, uint32_t first_instance,
                    uint32_t instance_count) {
    ASSIGN_OR_RETURN(gl::Program * program, UseProgram(drawable));
    gl_.FrontFace(drawable.is_mirrored ? GL_CCW : GL_CW);
    if (drawable.material->is_double_sided) {
      gl_.Disable(GL_CULL_FACE);
    } else {
      gl_.Enable(GL_CULL_FACE);
    }
    const uint32_t planes_per_step = std::max(1u, uint32_t(size_t(buffer_alignment_) / sizeof(glm::vec4)));
    for (uint32_t done = 0; done < drawable.triangle_count; done += kTrianglesPerDraw) {
      const uint32_t first = drawable.first_triangle + done;
      const uint32_t count = std::min(kTrianglesPerDraw, drawable.triangle_count - done);
      // The planes of these triangles alone, from the last aligned one: a block has a largest size.
      const uint32_t aligned = first / planes_per_step * planes_per_step;
      gl_.BindBufferRange(GL_SHADER_STORAGE_BUFFER, kPlanesBinding, planes.id(), GLintptr(aligned * sizeof(glm::vec4)),
                          GLsizeiptr((first - aligned + count) * sizeof(glm::vec4)));
      program->Set("first_triangle", int(first - aligned));
      const uint32_t instances_per_draw = kTrianglesPerDraw / count;
      for (uint32_t drawn = 0; drawn < instance_count; drawn += instances_per_draw) {
        const uint32_t instances = std::min(instances_per_draw, instance_count - drawn);
        RETURN_IF_ERROR(draw_.pacer->Charge(kMillisecondsPerTriangle * count * instances));
        gl_.DrawElementsInstancedBaseVertexBaseInstance(
            GL_TRIANGLES, GLsizei(3 * count), GL_UNSIGNED_INT,
            reinterpret_cast<const void*>(3 * sizeof(uint32_t) * size_t(first)), GLsizei(instances),
            GLint(drawable.base_vertex), first_instance + drawn);
      }
    }
    return absl::OkStatus();
  }

 private:
  // llvmpipe pays for what stands behind a uniform condition, so textures are compiled in or out; not one by one, since
  // every program costs a compilation at its first draw: a map that a material lacks is a white texel.
  absl::StatusOr<gl::Program*> UseProgram(const Drawable& drawable) {
    const MaterialTextures none;
    const MaterialTextures& textures = drawable.textures != nullptr ? *drawable.textures : none;
    const bool has_base_color = with_materials_ && textures.base_color;
    const bool has_maps =
        with_materials_ && (textures.metallic_roughness || textures.normal || textures.occlusion || textures.emissive);
    std::vector<std::string> defines;
    if (with_materials_) defines.push_back("HAS_MATERIAL");
    if (has_base_color) defines.push_back("HAS_BASE_COLOR_TEXTURE");
    if (has_maps) defines.push_back("HAS_MAPS");
    if (drawable.is_masked) defines.push_back("HAS_MASK");
    ASSIGN_OR_RETURN(gl::Program * program, draw_.programs->Get("shade/gbuffer.vert", "shade/gbuffer.frag", defines));
    program->Use();
    program->Set("is_orthographic", int(camera_.is_orthographic));
    program->Set("forward", glm::vec3(camera_.forward_ws));
    const Material& material = *drawable.material;
    program->Set("base_color", material.base_color);
    program->Set("alpha_cutoff", material.alpha_cutoff);
    program->Set("metallic", material.metallic);
    program->Set("roughness", material.roughness);
    program->Set("emissive", material.emissive);
    program->Set("normal_scale", textures.normal ? material.normal_scale : 0.0f);
    program->Set("occlusion_strength", material.occlusion_strength);
    program->Set("second_texcoord", SecondTexcoords(material));
    program->Set("has_mask_texture", int(bool(textures.mask)));
    if (drawable.is_masked) Bind(*program, "mask", kMaskUnit, textures.mask);
    if (has_base_color) Bind(*program, "base_color_texture", kBaseColorUnit, textures.base_color);
    if (has_maps) {
      RETURN_IF_ERROR(NeedWhite());
      Bind(*program, "metallic_roughness_texture", kMetallicRoughnessUnit, textures.metallic_roughness);
      Bind(*program, "normal_texture", kNormalUnit, textures.normal);
      Bind(*program, "occlusion_texture", kOcclusionUnit, textures.occlusion);
      Bind(*program, "emissive_texture", kEmissiveUnit, textures.emissive);
    }
    return program;
  }

  static int SecondTexcoords(const Material& material) {
    int bits = 0;
    const MaterialTexture* textures[] = {&material.base_color_texture, &material.metallic_roughness_texture,
                                         &material.normal_texture, &material.occlusion_texture,
                                         &material.emissive_texture};
    for (int unit = 0; unit < kMaskUnit; ++unit) bits |= int(textures[unit]->texcoord) << unit;
    return bits;
  }

  void Bind(gl::Program& program, const char* name, int unit, const SampledTexture& texture) {
    program.Set(name, unit);
    if (texture) {
      texture.Bind(unit);
    } else if (white_) {
      white_.Bind(unit);
      gl_.BindSampler(GLuint(unit), 0);
    }
  }

  absl::Status NeedWhite() {
    if (white_) return absl::OkStatus();
    ASSIGN_OR_RETURN(white_, gl::Texture::Create2D(*draw_.context, GL_RGBA8, 1, 1));
    const uint8_t white[4] = {255, 255, 255, 255};
    gl_.TextureSubImage2D(white_.id(), 0, 0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, white);
    return absl::OkStatus();
  }

  const DrawContext& draw_;
  const GladGLContext& gl_;
  const Camera& camera_;
  bool with_materials_;
  gl::Texture white_;
  glm::dmat4 flipped_clip_from_camera_;
  GLint buffer_alignment_ = 256;
};

// What the camera may see, gathered by mesh: of a run of triangles all instances are drawn at once. Surfaces at the
// same depth are seen in the order of meshes, then of triangles, then of instances.
class SceneBatch {
 public:
  SceneBatch(const FlatScene& scene, const SceneOnContext& on_context, bool with_materials)
      : scene_(scene), on_context_(on_context), with_materials_(with_materials) {}

  bool IsFull() const { return count_ >= kMostInstances; }

  void Add(uint32_t mesh, const TriangleRun& run, const InstanceAttributes& attributes) {
    instances_[{mesh, attributes.IsMirrored(), run.first, run.count}].push_back(attributes);
    ++count_;
  }

  // Leaves it empty.
  absl::Status Draw(const gl::Context& context, GBufferPass& pass) {
    std::vector<InstanceAttributes> all;
    all.reserve(count_);
    for (const auto& [key, instances] : instances_) all.insert(all.end(), instances.begin(), instances.end());
    if (all.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(const gl::Buffer buffer, gl::Buffer::Create(context, all));
    context.gl().BindVertexArray(on_context_.vertex_array().id());
    SetInstances(on_context_.vertex_array(), buffer);
    uint32_t first_instance = 0;
    for (const auto& [key, instances] : instances_) {
      const auto& [mesh_index, is_mirrored, first, count] = key;
      const Mesh& mesh = scene_.meshes[mesh_index];
      Drawable drawable;
      drawable.material = &scene_.materials[mesh.material];
      drawable.is_masked = scene_.SeenCoverageOf(mesh) == MaskCoverage::kTested;
      if (with_materials_ || drawable.is_masked) drawable.textures = &on_context_.textures(mesh.material);
      drawable.is_mirrored = is_mirrored;
      drawable.first_triangle = mesh.first_index / 3 + first;
      drawable.triangle_count = count;
      drawable.base_vertex = mesh.first_vertex;
      RETURN_IF_ERROR(pass.Draw(drawable, on_context_.triangle_planes(), first_instance, uint32_t(instances.size())));
      first_instance += uint32_t(instances.size());
    }
    instances_.clear();
    count_ = 0;
    return absl::OkStatus();
  }

 private:
  const FlatScene& scene_;
  const SceneOnContext& on_context_;
  bool with_materials_;
  // Of mesh, is_mirrored, first triangle, number of triangles.
  std::map<std::tuple<uint32_t, bool, uint32_t, uint32_t>, std::vector<InstanceAttributes>> instances_;
  size_t count_ = 0;
};

absl::Status DrawGround(const DrawContext& draw, GBufferPass& pass, const RenderRequest& request, uint32_t object_id) {
  const gl::Context& context = *draw.context;
  const GladGLContext& gl = context.gl();
  const std::array<glm::dvec3, 4> corners = GroundQuad(request);
  const glm::dvec3 center = (corners[0] + corners[2]) * 0.5;
  std::vector<glm::vec3> positions;
  for (const glm::dvec3& corner : corners) positions.emplace_back(corner - center);
  // Both windings: seen from above and from below.
  const std::vector<uint32_t> indices = {0, 1, 2, 0, 2, 3};
  const std::vector<glm::vec4> planes(2, glm::vec4(0, 1, 0, 0));
  ASSIGN_OR_RETURN(gl::Buffer position_buffer, gl::Buffer::Create(context, positions));
  ASSIGN_OR_RETURN(gl::Buffer index_buffer, gl::Buffer::Create(context, indices));
  ASSIGN_OR_RETURN(gl::Buffer plane_buffer, gl::Buffer::Create(context, planes));
  gl::VertexArray vertex_array = gl::VertexArray::Create(context);
  vertex_array.SetFloats(0, 3, position_buffer.id());
  gl.VertexArrayElementBuffer(vertex_array.id(), index_buffer.id());
  gl.BindVertexArray(vertex_array.id());
  const std::vector<InstanceAttributes> instances = {
      *pass.Attributes(glm::translate(glm::dmat4(1), center), true, object_id)};
  ASSIGN_OR_RETURN(const gl::Buffer instance_buffer, gl::Buffer::Create(context, instances));
  SetInstances(vertex_array, instance_buffer);
  Drawable ground;
  const Material material = GroundMaterial();
  ground.material = &material;
  ground.triangle_count = 2;
  return pass.Draw(ground, plane_buffer, 0, 1);
}

}  // namespace

uint32_t GroundId(const FlatScene& scene) { return uint32_t(scene.nodes.size()) + 1; }

absl::StatusOr<GBuffer> DrawGBuffer(const DrawContext& draw, const FlatScene& scene, const SceneOnContext& on_context,
                                    const Pose& pose, const RenderRequest& request, GBufferChannels channels) {
  const gl::Context& context = *draw.context;
  const GladGLContext& gl = context.gl();
  GBuffer gbuffer;
  ASSIGN_OR_RETURN(gbuffer.planes, gl::Texture::Create2D(context, GL_RGBA32F, request.width, request.height));
  ASSIGN_OR_RETURN(gbuffer.depth, gl::Texture::Create2D(context, GL_DEPTH_COMPONENT32F, request.width, request.height));
  std::vector<const gl::Texture*> colors = {&gbuffer.planes};
  if (channels.materials) {
    ASSIGN_OR_RETURN(gbuffer.normals, gl::Texture::Create2D(context, GL_RGBA32F, request.width, request.height));
    ASSIGN_OR_RETURN(gbuffer.base_colors, gl::Texture::Create2D(context, GL_RGBA16F, request.width, request.height));
    ASSIGN_OR_RETURN(gbuffer.emissions, gl::Texture::Create2D(context, GL_RGBA16F, request.width, request.height));
    colors = {&gbuffer.planes, &gbuffer.normals, &gbuffer.base_colors, &gbuffer.emissions};
  }
  if (channels.object_ids) {
    ASSIGN_OR_RETURN(gbuffer.object_ids, gl::Texture::Create2D(context, GL_R32F, request.width, request.height));
    colors.resize(kObjectIdLocation + 1);
    colors.back() = &gbuffer.object_ids;
  }
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::Create(context, colors, &gbuffer.depth));
  framebuffer.Bind();
  gl.Viewport(0, 0, request.width, request.height);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_TRUE);
  gl.Disable(GL_BLEND);
  gl.CullFace(GL_BACK);
  const float zero[4] = {0, 0, 0, 0};
  for (int i = 0; i < int(colors.size()); ++i) {
    if (colors[i] != nullptr) gl.ClearBufferfv(GL_COLOR, i, zero);
  }
  gl.ClearBufferfv(GL_DEPTH, 0, zero);
  SetAbsentAttributes(context);
  GBufferPass pass(draw, request, channels.materials);
  RETURN_IF_ERROR(draw.pacer->Charge(kMillisecondsPerPixel * request.width * request.height));
  SceneBatch batch(scene, on_context, channels.materials);
  const double aspect = double(request.width) / request.height;
  for (const Instance& instance : pose.instances) {
    if (!instance.is_visible) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (scene.SeenCoverageOf(mesh) == MaskCoverage::kNothing) continue;
    const auto attributes = pass.Attributes(instance.world_from_mesh, instance.receives, instance.node + 1);
    gbuffer.triangles_out_of_view += mesh.TriangleCount();
    for (const TriangleRun& run : SeenTriangles(scene, instance, request.camera, aspect)) {
      if (attributes) batch.Add(instance.mesh, run, *attributes);
      gbuffer.triangles_drawn += run.count;
      gbuffer.triangles_out_of_view -= run.count;
    }
    if (batch.IsFull()) RETURN_IF_ERROR(batch.Draw(context, pass));
  }
  RETURN_IF_ERROR(batch.Draw(context, pass));
  if (request.ground) RETURN_IF_ERROR(DrawGround(draw, pass, request, GroundId(scene)));
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_DEPTH_TEST);
  RETURN_IF_ERROR(context.Check("gbuffer"));
  return gbuffer;
}

}  // namespace halfshade
