#include "client/points_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

class PointsFileTest : public testing::Test {
 protected:
  absl::StatusOr<PackedPoints> Read(const std::string& text) {
    std::ofstream(folder_.path() / "p.csv") << text;
    return ReadPointsFile((folder_.path() / "p.csv").string());
  }
  static std::vector<float> Unpack(const std::string& bytes) {
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  TemporaryFolder folder_;
};

TEST_F(PointsFileTest, ALineIsAPoint) {
  const auto packed = Read("x,y,z\n\n# a comment\n1,2,-3e2\r\n .5 , 0,1");
  ASSERT_OK(packed);
  EXPECT_EQ(Unpack(packed->points), std::vector<float>({1, 2, -300, 0.5f, 0, 1}));
  EXPECT_EQ(packed->normals, "");
}

TEST_F(PointsFileTest, SixValuesAreAPointAndItsNormal) {
  const auto packed = Read("1,2,3,0,1,0\n4,5,6,0,0,1\n");
  ASSERT_OK(packed);
  EXPECT_EQ(Unpack(packed->points), std::vector<float>({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(Unpack(packed->normals), std::vector<float>({0, 1, 0, 0, 0, 1}));
}

TEST_F(PointsFileTest, AFaultNamesItsLine) {
  const auto invalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(Read("1,2,3\n1,2\n"), StatusIs(invalid, testing::HasSubstr("p.csv:2: 2 values; must be x,y,z")));
  EXPECT_THAT(Read("1,2,3\n1,2,3,0,1,0\n"),
              StatusIs(invalid, testing::HasSubstr("p.csv:2: 6 values; the lines before have 3")));
  EXPECT_THAT(Read("1,2,3\nx,y,z\n"), StatusIs(invalid, testing::HasSubstr("p.csv:2: not numbers: 'x,y,z'")));
  EXPECT_THAT(Read("1,two,3\n"), StatusIs(invalid, testing::HasSubstr("p.csv:1: not numbers: '1,two,3'")));
  EXPECT_THAT(Read("x,y,z\n"), StatusIs(invalid, testing::HasSubstr("no points")));
  EXPECT_THAT(ReadPointsFile((folder_.path() / "absent.csv").string()),
              StatusIs(absl::StatusCode::kNotFound, testing::_));
}

}  // namespace
}  // namespace halfshade
