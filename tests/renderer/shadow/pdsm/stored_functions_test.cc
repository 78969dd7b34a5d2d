// Functions as bytes: what comes back is what went in, or nothing.
#include "renderer/shadow/pdsm/stored_functions.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "renderer/shadow/pdsm/event_builder.h"
#include "tests/renderer/shadow/pdsm/made_maps.h"

namespace halfshade::pdsm {
namespace {

constexpr int kSize = 40;

StoredFunctions MakeFunctions() {
  const MadeMaps made = DrawMaps(Clutter(20, 1, 0.5), 8, kSize, kSize);
  EventBuilder builder(made.grid, EventForm::kScatter);
  for (const SampleMap& map : made.maps) EXPECT_TRUE(builder.Add(map).ok());
  return {made.grid, builder.Finish({.eps = 0.1f})->functions};
}

StoredFunctions MakeVolume() {
  const MadeMaps made = DrawMaps(Clutter(20, 1, 0.5), 8, kSize, kSize);
  SliceBuilder builder(made.grid, SpaceSlices(12, 0.6).Depths());
  for (const SampleMap& map : made.maps) builder.Add(map);
  return {made.grid, builder.Finish()};
}

bool AreEqual(const StoredFunctions& a, const StoredFunctions& b) {
  if (a.grid != b.grid || a.functions.index() != b.functions.index()) return false;
  if (const auto* volume = std::get_if<SliceVolume>(&a.functions)) {
    const auto& other = std::get<SliceVolume>(b.functions);
    return volume->size == other.size && volume->maps == other.maps && volume->depths == other.depths &&
           volume->counts == other.counts;
  }
  const auto& functions = std::get<AttenuationFunctions>(a.functions);
  const auto& other = std::get<AttenuationFunctions>(b.functions);
  return functions.size == other.size && functions.first == other.first &&
         functions.vertices.size() == other.vertices.size() &&
         std::memcmp(functions.vertices.data(), other.vertices.data(), functions.vertices.size() * sizeof(Vertex)) == 0;
}

class StoredFunctionsTest : public testing::TestWithParam<StoredFunctions (*)()> {};
INSTANTIATE_TEST_SUITE_P(Forms, StoredFunctionsTest, testing::Values(MakeFunctions, MakeVolume));

TEST_P(StoredFunctionsTest, ComeBackAsTheyWere) {
  const StoredFunctions stored = GetParam()();
  const auto restored = Restore(Store(stored));
  ASSERT_TRUE(restored.has_value());
  EXPECT_TRUE(AreEqual(stored, *restored));
}

TEST_P(StoredFunctionsTest, CutAnywhereAreRefused) {
  const std::string bytes = Store(GetParam()());
  for (size_t size = 0; size < bytes.size(); size += size < 300 ? 1 : 997) {
    ASSERT_FALSE(Restore(bytes.substr(0, size)).has_value()) << size << " of " << bytes.size() << " bytes";
  }
  EXPECT_FALSE(Restore(bytes + "x").has_value());
}

TEST_P(StoredFunctionsTest, WithAnyBitTurnedAreRefused) {
  const std::string bytes = Store(GetParam()());
  std::mt19937 random(3);
  for (int i = 0; i < 4000; ++i) {
    std::string turned = bytes;
    const size_t at = i < 400 ? size_t(i / 4) : random() % bytes.size();
    turned[at] = char(turned[at] ^ (1 << random() % 8));
    ASSERT_FALSE(Restore(turned).has_value()) << "byte " << at;
  }
}

// A checksum can be made to fit; the numbers that lookups go by cannot.
TEST(StoredFunctionsTest, NumbersThatALookupCannotUseAreRefused) {
  const StoredFunctions good = MakeFunctions();
  const auto refused = [&](auto&& change) {
    StoredFunctions bad = good;
    change(bad.grid, std::get<AttenuationFunctions>(bad.functions));
    return !Restore(Store(bad)).has_value();
  };
  EXPECT_FALSE(refused([](Grid&, AttenuationFunctions&) {}));
  EXPECT_TRUE(refused([](Grid& grid, AttenuationFunctions&) { grid.size = 0; }));
  EXPECT_TRUE(refused([](Grid& grid, AttenuationFunctions&) { grid.size = kSize + 1; }));
  EXPECT_TRUE(refused([](Grid& grid, AttenuationFunctions&) { grid.texel.x = NAN; }));
  EXPECT_TRUE(refused([](Grid& grid, AttenuationFunctions&) { grid.z_near = 0; }));
  EXPECT_TRUE(refused([](Grid&, AttenuationFunctions& functions) { functions.first[7] = 1u << 30; }));
  EXPECT_TRUE(refused([](Grid&, AttenuationFunctions& functions) { functions.first.back() += 1; }));
  EXPECT_TRUE(refused([](Grid&, AttenuationFunctions& functions) { functions.vertices[5].value = 1.5f; }));
  EXPECT_TRUE(refused([](Grid&, AttenuationFunctions& functions) { functions.vertices[5].value = NAN; }));
  EXPECT_TRUE(refused([](Grid&, AttenuationFunctions& functions) { functions.vertices[5].depth = -0.1f; }));
  StoredFunctions volume = MakeVolume();
  std::get<SliceVolume>(volume.functions).counts[3].hidden = 9;
  EXPECT_FALSE(Restore(Store(volume)).has_value()) << "of eight maps";
}

TEST(StoredFunctionsTest, OfAnotherVersionAreRefused) {
  std::string bytes = Store(MakeFunctions());
  const size_t at = bytes.find('1');
  ASSERT_LT(at, 16u);
  bytes[at] = '0';
  EXPECT_FALSE(Restore(bytes).has_value());
}

}  // namespace
}  // namespace halfshade::pdsm
