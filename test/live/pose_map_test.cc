#include "hpgo/live/pose_map.h"

#include <limits>
#include <map>
#include <random>
#include <vector>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

using Reference = std::map<NodeId, double>;

void ExpectEqual(const PoseMap<SE2>& map, const Reference& reference) {
  ASSERT_EQ(map.size(), reference.size());
  auto it = reference.begin();
  map.ForEach([&](NodeId id, const SE2& pose) {
    ASSERT_NE(it, reference.end());
    EXPECT_EQ(id, it->first);
    EXPECT_EQ(pose.data()[0], it->second);
    ++it;
  });
  for (const auto& [id, x] : reference) {
    ASSERT_NE(map.Find(id), nullptr) << id;
    EXPECT_EQ(map.Find(id)->data()[0], x);
  }
}

// Dense ids, sparse ones, negative ones; every version stays as it was published.
TEST(PoseMapTest, VersionsDoNotChange) {
  constexpr NodeId kMin = std::numeric_limits<NodeId>::min(),
                   kMax = std::numeric_limits<NodeId>::max();
  for (int kind = 0; kind < 3; ++kind) {
    std::mt19937_64 rng(kind);
    const auto random_id = [&]() -> NodeId {
      if (kind == 0) return static_cast<NodeId>(rng() % 3000);
      if (kind == 1) return static_cast<NodeId>(rng() % 200) * 1'000'003 - 50'000'000;
      const NodeId ends[] = {kMin, kMin + 1, -1, 0, 1, 31, 32, kMax - 1, kMax};
      return rng() % 2 == 0 ? ends[rng() % 9] : static_cast<NodeId>(rng());
    };
    PoseMapWriter<SE2> writer;
    Reference reference;
    std::vector<std::pair<PoseMap<SE2>, Reference>> versions;
    for (int step = 0; step < 40; ++step) {
      for (int k = 0; k < 60; ++k) {
        const NodeId id = random_id();
        if (rng() % 3 == 0) {
          writer.Erase(id);
          reference.erase(id);
        } else {
          const double x = static_cast<double>(rng() % 1000);
          writer.Set(id, SE2(x, 0, 0));
          reference[id] = x;
        }
      }
      versions.emplace_back(writer.Publish(), reference);
      EXPECT_EQ(versions.back().first.Find(123'456'789'012), nullptr);
    }
    for (const auto& [map, expected] : versions) ExpectEqual(map, expected);
    while (!reference.empty()) {
      writer.Erase(reference.begin()->first);
      reference.erase(reference.begin());
    }
    ExpectEqual(writer.Publish(), reference);
  }
}

// What has not changed is shared.
TEST(PoseMapTest, AVersionCopiesWhatHasChanged) {
  PoseMapWriter<SE2> writer;
  for (NodeId id = 0; id < 10'000; ++id) writer.Set(id, SE2());
  const PoseMap<SE2> before = writer.Publish();
  writer.Set(5000, SE2(1, 2, 3));
  const PoseMap<SE2> after = writer.Publish();
  int shared = 0;
  for (NodeId id = 0; id < 10'000; ++id) shared += before.Find(id) == after.Find(id);
  EXPECT_EQ(shared, 10'000 - 32);
  EXPECT_EQ(before.Find(5000)->data()[0], 0);
  EXPECT_EQ(after.Find(5000)->data()[0], 1);
}

}  // namespace
}  // namespace hpgo
