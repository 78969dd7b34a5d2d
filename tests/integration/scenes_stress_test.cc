// The long form of what scenes_test.cc shows in short.
#include "tests/integration/scenes_fixture.h"

namespace halfshade {
namespace {

using ScenesStressTest = ScenesTest;

TEST_F(ScenesStressTest, FortyMebibytesCutAtEveryChunkGoOnFromThere) { CutEverywhere(40 << 20, 1 << 20, true); }

}  // namespace
}  // namespace halfshade
