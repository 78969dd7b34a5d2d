// The same picture from other drivers, backends, numbers of threads and of contexts. What is chosen before a process
// has a context is drawn by draw_still, a process of its own.
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <thread>

#include "tests/client/temporary_folder.h"
#include "tests/stress/stress_fixture.h"

namespace halfshade {
namespace {

struct Drawn {
  std::string renderer;  // GL_RENDERER; "": it failed
  Image visibility;
};

// draw_still with these variables ("NAME=value") before ours.
Drawn DrawElsewhere(const std::string& method, std::vector<std::string> variables, int cpus = 0,
                    const char* kind = "image") {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  std::vector<std::string> arguments = {DRAW_STILL_BINARY, method, kind, std::to_string(cpus), out};
  std::vector<char*> argv, environment;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const auto is_set_anew = [&](const char* variable) {
    for (const std::string& own : variables) {
      if (std::strncmp(variable, own.c_str(), own.find('=') + 1) == 0) return true;
    }
    return false;
  };
  for (std::string& variable : variables) environment.push_back(variable.data());
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (!is_set_anew(*variable)) environment.push_back(*variable);
  }
  environment.push_back(nullptr);
  pid_t pid = -1;
  int status = -1;
  if (posix_spawn(&pid, DRAW_STILL_BINARY, nullptr, nullptr, argv.data(), environment.data()) != 0 ||
      waitpid(pid, &status, 0) != pid || status != 0) {
    return {};
  }
  const std::string bytes = ReadAll(out);
  const size_t end = bytes.find('\n');
  Drawn drawn = {bytes.substr(0, end), Image(kStressSize, kStressSize, 1)};
  if (end == std::string::npos || bytes.size() - end - 1 != drawn.visibility.size() * sizeof(float)) return {};
  std::memcpy(drawn.visibility.data(), bytes.data() + end + 1, bytes.size() - end - 1);
  return drawn;
}

class DriversStressTest : public StressTest {
 protected:
  // A figure of `row` that holds where no bit differs.
  void BitEqualRow(const std::string& row, const std::string& what, const Image& a, const Image& b) {
    const Difference d = Between(a, b, 0);
    Row(row, d.is_finite && d.max == 0, what + ": " + Text(d));
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, DriversStressTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST_P(DriversStressTest, EglAndOsmesaOfOneMesaGiveTheSameBytes) {
  const Drawn egl = DrawElsewhere(GetParam().name, {"HALFSHADE_TEST_GL=egl"});
  const Drawn osmesa = DrawElsewhere(GetParam().name, {"HALFSHADE_TEST_GL=osmesa"});
  ASSERT_NE(egl.renderer, "");
  ASSERT_NE(osmesa.renderer, "");
  if (egl.renderer != osmesa.renderer) GTEST_SKIP() << egl.renderer << " is not " << osmesa.renderer;
  BitEqualRow("EGL against OSMesa", egl.renderer, egl.visibility, osmesa.visibility);
}

TEST_P(DriversStressTest, TheNumberOfThreadsChangesNoByte) {
  const Drawn usual = DrawElsewhere(GetParam().name, {});
  ASSERT_NE(usual.renderer, "");
  for (const char* threads : {"0", "1", "2", "3"}) {
    const Drawn other = DrawElsewhere(GetParam().name, {std::string("LP_NUM_THREADS=") + threads});
    BitEqualRow("threads", std::string(threads) + " of the driver", usual.visibility, other.visibility);
  }
  BitEqualRow("threads", "one CPU", usual.visibility, DrawElsewhere(GetParam().name, {}, 1).visibility);
}

// Each with a renderer and a thread of its own, as the server has them.
TEST_P(DriversStressTest, TheNumberOfContextsThatDrawAtOnceChangesNoByte) {
  const Image alone = DrawStill(GetParam().options);
  for (const size_t contexts : {size_t(1), size_t(3)}) {
    std::vector<Image> images(contexts);
    std::vector<std::thread> threads;
    for (Image& image : images) threads.emplace_back([&] { image = DrawStillOnANewContext(GetParam().options); });
    for (std::thread& thread : threads) thread.join();
    for (const Image& image : images) {
      BitEqualRow("contexts", std::to_string(contexts) + " at once", alone, image);
    }
  }
}

// Another rasteriser, with an edge rule and an interpolation of its own. It gives fragments no gl_PrimitiveID without a
// geometry shader, so of all passes the G-buffer's cannot run there: the points are named instead of seen.
TEST_P(DriversStressTest, SoftpipeAnswersAsLlvmpipeDoes) {
  const Drawn llvmpipe =
      DrawElsewhere(GetParam().name, {"HALFSHADE_TEST_GL=osmesa", "GALLIUM_DRIVER=llvmpipe"}, 0, "points");
  const Drawn softpipe = DrawElsewhere(GetParam().name,
                                       {"HALFSHADE_TEST_GL=osmesa", "GALLIUM_DRIVER=softpipe",
                                        "MESA_GL_VERSION_OVERRIDE=4.5", "MESA_GLSL_VERSION_OVERRIDE=450"},
                                       0, "points");
  ASSERT_NE(llvmpipe.renderer.find("llvmpipe"), std::string::npos) << llvmpipe.renderer;
  ASSERT_NE(softpipe.renderer.find("softpipe"), std::string::npos) << softpipe.renderer;
  const Difference d = Between(llvmpipe.visibility, softpipe.visibility, 0.01);
  EXPECT_LT(*std::min_element(softpipe.visibility.data(), softpipe.visibility.data() + softpipe.visibility.size()), 0.1)
      << "there is an umbra";
  Row("softpipe", d.is_finite && d.share_over <= 1e-3, Text(d));
}

}  // namespace
}  // namespace halfshade
