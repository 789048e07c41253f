#include "hpgo/graph/id_map.h"

#include <limits>
#include <map>
#include <random>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

TEST(IdMapTest, FindsWhatWasSet) {
  IdMap map;
  EXPECT_EQ(map.Find(7), IdMap::kAbsent);
  map.Set(7, 3);
  map.Set(-1, 4);
  EXPECT_EQ(map.Find(7), 3);
  EXPECT_EQ(map.Find(-1), 4);
  EXPECT_EQ(map.Find(6), IdMap::kAbsent);
  map.Erase(7);
  EXPECT_EQ(map.Find(7), IdMap::kAbsent);
}

TEST(IdMapTest, TakesTheExtremes) {
  IdMap map;
  map.Set(std::numeric_limits<std::int64_t>::min(), 1);
  map.Set(std::numeric_limits<std::int64_t>::max(), 2);
  EXPECT_EQ(map.Find(std::numeric_limits<std::int64_t>::min()), 1);
  EXPECT_EQ(map.Find(std::numeric_limits<std::int64_t>::max()), 2);
}

TEST(IdMapTest, EqualsAStandardMapUnderRandomCalls) {
  std::mt19937_64 rng(1);
  IdMap map;
  std::map<std::int64_t, std::int32_t> expected;
  for (int step = 0; step < 20000; ++step) {
    const std::int64_t id = static_cast<std::int64_t>(rng() % 500) - 250;
    if (rng() % 3 == 0) {
      map.Erase(id);
      expected.erase(id);
    } else {
      map.Set(id, step);
      expected[id] = step;
    }
  }
  auto it = expected.begin();
  map.ForEach([&](std::int64_t id, std::int32_t value) {
    ASSERT_NE(it, expected.end());
    EXPECT_EQ(id, it->first);
    EXPECT_EQ(value, it->second);
    ++it;
  });
  EXPECT_EQ(it, expected.end());
  for (const auto& [id, value] : expected) map.Erase(id);
  EXPECT_EQ(map.MemoryBytes(), 0u);
}

}  // namespace
}  // namespace hpgo
