#include <glad/gl.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <thread>

#include "renderer/gl/context.h"
#include "renderer/gl/framebuffer.h"
#include "renderer/gl/program.h"
#include "renderer/gl/turn.h"
#include "tests/support/status_matchers.h"

namespace halfshade::gl {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr char kFullscreen[] = R"(#version 450 core
void main() { gl_Position = vec4(vec2((gl_VertexID & 1) * 4, (gl_VertexID >> 1) * 4) - 1.0, 0.25, 1.0); })";
constexpr char kGradient[] = R"(#version 450 core
layout(location = 0) out vec4 color;
void main() { color = vec4(gl_FragCoord.xy, gl_FragCoord.z, 7.0); })";

class ContextTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    auto context = Context::Create({GetParam()});
    ASSERT_OK(context);
    context_ = *std::move(context);
  }
  std::unique_ptr<Context> context_;
};
INSTANTIATE_TEST_SUITE_P(Backends, ContextTest, testing::Values(Backend::kEgl, Backend::kOsmesa),
                         [](const auto& backend) { return backend.param == Backend::kEgl ? "Egl" : "Osmesa"; });

TEST_P(ContextTest, IsCore45AndNamesItself) {
  EXPECT_EQ(context_->backend(), GetParam());
  EXPECT_THAT(context_->version(), testing::StartsWith("4.5"));
  EXPECT_FALSE(context_->renderer().empty());
  EXPECT_FALSE(context_->description().empty());
  EXPECT_OK(context_->Check("nothing"));
}

TEST_P(ContextTest, CheckCatchesAGlErrorOnceAndNamesThePass) {
  context_->gl().Enable(0xdead);
  EXPECT_THAT(context_->Check("the pass"),
              StatusIs(absl::StatusCode::kInternal, AllOf(HasSubstr("the pass"), HasSubstr("GL_INVALID_ENUM"))));
  EXPECT_OK(context_->Check("the pass"));
}

TEST_P(ContextTest, DrawsAndReadsBackExactlyWithReversedDepthFromZeroToOne) {
  auto color = Texture::Create2D(*context_, GL_RGBA32F, 5, 3);
  auto depth = Texture::Create2D(*context_, GL_DEPTH_COMPONENT32F, 5, 3);
  ASSERT_OK(color);
  ASSERT_OK(depth);
  auto framebuffer = Framebuffer::Create(*context_, {&*color}, &*depth);
  ASSERT_OK(framebuffer);
  auto program = Program::CompileSources(*context_, "v", kFullscreen, "f", kGradient);
  ASSERT_OK(program);
  const GladGLContext& gl = context_->gl();
  framebuffer->Bind();
  gl.Viewport(0, 0, 5, 3);
  const float zero[4] = {0, 0, 0, 0};
  gl.ClearBufferfv(GL_DEPTH, 0, zero);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  const VertexArray none = VertexArray::Create(*context_);
  gl.BindVertexArray(none.id());
  program->Use();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  ASSERT_OK(context_->Check("draw"));
  std::vector<float> pixels(5 * 3 * 4), depths(15);
  ASSERT_OK(color->ReadFloats(pixels.data(), pixels.size()));
  ASSERT_OK(depth->ReadFloats(depths.data(), depths.size()));
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(pixels[size_t(4 * (5 * y + x))], float(x) + 0.5f);
      EXPECT_EQ(pixels[size_t(4 * (5 * y + x) + 1)], float(y) + 0.5f);
      EXPECT_EQ(pixels[size_t(4 * (5 * y + x) + 2)], 0.25f) << "clip z is window z";
      EXPECT_EQ(depths[size_t(5 * y + x)], 0.25f);
    }
  }
}

TEST_P(ContextTest, AShaderThatDoesNotCompileTellsPathAndLog) {
  EXPECT_THAT(
      Program::CompileSources(*context_, "my.vert", kFullscreen, "my.frag", "#version 450 core\nvoid main() { oops; }"),
      StatusIs(absl::StatusCode::kInternal, AllOf(HasSubstr("shaders/my.frag"), HasSubstr("oops"))));
}

TEST_P(ContextTest, AMovedFromHandleOwnsNothing) {
  auto made = Texture::Create2D(*context_, GL_R32F, 4, 4);
  ASSERT_OK(made);
  Texture a = *std::move(made);
  const GLuint id = a.id();
  const Texture b = std::move(a);
  EXPECT_EQ(b.id(), id);
  EXPECT_FALSE(bool(a));
  EXPECT_EQ(b.SizeBytes(), 64u);
}

TEST_P(ContextTest, AnImpossibleSizeIsAStatus) {
  EXPECT_THAT(Texture::Create2D(*context_, GL_R32F, 1 << 20, 1 << 20).status().code(),
              absl::StatusCode::kResourceExhausted);
  EXPECT_OK(context_->Check("after"));
}

TEST(ContextsTest, BothKindsLiveInOneProcessOnTwoThreads) {
  const auto clear = [](Backend backend, float value) {
    auto context = Context::Create({backend});
    ASSERT_OK(context);
    auto texture = Texture::Create2D(**context, GL_R32F, 64, 64);
    ASSERT_OK(texture);
    auto framebuffer = Framebuffer::Create(**context, {&*texture});
    ASSERT_OK(framebuffer);
    framebuffer->Bind();
    for (int i = 0; i < 100; ++i) {
      const float color[4] = {value + float(i), 0, 0, 0};
      (*context)->gl().ClearBufferfv(GL_COLOR, 0, color);
      std::vector<float> pixels(64 * 64);
      ASSERT_OK(texture->ReadFloats(pixels.data(), pixels.size()));
      ASSERT_EQ(pixels[4095], value + float(i));
    }
  };
  std::thread egl([&] { clear(Backend::kEgl, 1000); });
  std::thread osmesa([&] { clear(Backend::kOsmesa, 2000); });
  egl.join();
  osmesa.join();
}

// Scenes of many textures and triangles on one thread, on the other uploads, each of which walks all scenes. What is
// freed is overwritten, so that without turns it crashes within a second.
TEST_P(ContextTest, OneDrawsWhileAnotherUploads) {
  mallopt(M_PERTURB, 0xa5);
  constexpr int kScenes = 300, kTextures = 40, kInstances = 64;
  constexpr char kSampled[] = R"(#version 450 core
layout(binding = 0) uniform sampler2D image;
layout(location = 0) out vec4 color;
void main() { color = texelFetch(image, ivec2(0), 0); })";
  const auto make_textures = [](const Context& context) {
    std::vector<Texture> textures;
    for (int i = 0; i < kTextures; ++i) {
      auto texture = Texture::Create2D(context, GL_R32F, 4, 4);
      EXPECT_OK(texture);
      textures.push_back(*std::move(texture));
      const float color = float(i);
      context.gl().ClearTexImage(textures.back().id(), 0, GL_RED, GL_FLOAT, &color);
    }
    return textures;
  };
  std::atomic<bool> is_done = false;
  std::thread drawing([&] {
    auto context = Context::Create({GetParam()});
    ASSERT_OK(context);
    const Turn turn(**context);
    const GladGLContext& gl = (*context)->gl();
    auto program = Program::CompileSources(**context, "v", kFullscreen, "f", kSampled);
    ASSERT_OK(program);
    program->Use();
    const VertexArray none = VertexArray::Create(**context);
    gl.BindVertexArray(none.id());
    gl.Viewport(0, 0, 4, 4);
    const std::vector<Texture> textures = make_textures(**context);
    auto target = Texture::Create2D(**context, GL_R32F, 4, 4);
    ASSERT_OK(target);
    auto framebuffer = Framebuffer::Create(**context, {&*target});
    ASSERT_OK(framebuffer);
    framebuffer->Bind();
    for (int scene = 0; scene < kScenes; ++scene) {
      for (const Texture& texture : textures) {
        texture.Bind(0);
        gl.DrawArraysInstanced(GL_TRIANGLES, 0, 3, kInstances);
      }
      gl.Flush();
      PassTurn();
    }
    std::vector<float> pixels(4 * 4);
    ASSERT_OK(target->ReadFloats(pixels.data(), pixels.size()));
    EXPECT_EQ(pixels[0], float(kTextures - 1));
    is_done = true;
  });
  auto context = Context::Create({GetParam()});
  ASSERT_OK(context);
  const Turn turn(**context);
  const std::vector<Texture> textures = make_textures(**context);
  for (float value = 0; !is_done; value += 1) {
    textures[0].Bind(0);
    (*context)->gl().TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 1, 1, GL_RED, GL_FLOAT, &value);
    PassTurn();
  }
  {
    const TurnPause pause;
    drawing.join();
  }
  mallopt(M_PERTURB, 0);
}

TEST(ContextsTest, AnImpossibleDeviceIsRefusedWithEverythingThatWasTried) {
  EXPECT_THAT(Context::Create({Backend::kEgl, 99}),
              StatusIs(absl::StatusCode::kFailedPrecondition, AllOf(HasSubstr("tried"), HasSubstr("EGL device 99"))));
}

TEST(ContextsTest, TheDoctorTriesEveryWay) {
  const std::vector<DoctorLine> lines = Diagnose();
  ASSERT_GE(lines.size(), 2u);
  EXPECT_EQ(lines.back().what, "OSMesa");
  EXPECT_TRUE(lines.back().is_ok) << lines.back().detail;
}

TEST(AssembleShaderTest, IncludesEachFileOnceAndNamesWhatIsMissing) {
  const auto source = AssembleShader("light/resolve_sample_maps.frag", {"SOME 1"});
  ASSERT_OK(source);
  EXPECT_THAT(*source, testing::StartsWith("#version 450 core\n#define SOME 1\n"));
  EXPECT_THAT(*source, HasSubstr("struct Receiver"));
  EXPECT_EQ(source->find("#include"), std::string::npos);
  EXPECT_THAT(AssembleShader("no/such.frag", {}),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("shaders/no/such.frag")));
}

}  // namespace
}  // namespace halfshade::gl
