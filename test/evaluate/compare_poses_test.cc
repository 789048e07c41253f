#include "hpgo/evaluate/compare_poses.h"

#include "gtest/gtest.h"
#include "test/evaluate/random_poses.h"

namespace hpgo {
namespace {

template <typename G>
PoseGraph<G> Graph(const std::vector<G>& poses, const std::vector<NodeId>& ids) {
  PoseGraph<G> graph;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    GraphNode<G> node;
    node.id = ids[k];
    node.pose = poses[k];
    EXPECT_TRUE(graph.AddNode(node).ok());
  }
  return graph;
}

TEST(ComparePosesTest, MatchesByIdUpToGauge) {
  std::mt19937_64 rng(11);
  const auto poses = RandomPoses<SE3>(&rng, 4);
  const auto moved = Moved(RandomPose<SE3>(&rng), poses);
  const auto reference = Graph<SE3>(poses, {5, 1, 9, 2});
  const auto graph = Graph<SE3>({moved[3], moved[2], moved[1], moved[0]}, {2, 9, 1, 5});
  const auto same = ComparePosesUpToGauge(graph, reference);
  ASSERT_TRUE(same.ok()) << same.status().ToString();
  EXPECT_LT(same->translation.max, 1e-12);
  EXPECT_LT(same->rotation.max, 1e-12);
  const auto unaligned = ComparePoses(graph, reference);
  ASSERT_TRUE(unaligned.ok());
  EXPECT_GT(unaligned->translation.max, 0.1);
}

TEST(ComparePosesTest, FindsTheNodeThatDiffers) {
  std::mt19937_64 rng(12);
  const auto poses = RandomPoses<SE2>(&rng, 3);
  auto changed = poses;
  changed[1].translation()(0) += 0.5;
  const auto difference =
      ComparePoses(Graph<SE2>(changed, {0, 1, 2}), Graph<SE2>(poses, {0, 1, 2}));
  ASSERT_TRUE(difference.ok());
  EXPECT_NEAR(difference->translation.max, 0.5, 1e-12);
  EXPECT_EQ(difference->translation.max_index, 1);
}

TEST(ComparePosesTest, NamesAMissingNode) {
  const auto two = Graph<SE2>(std::vector<SE2>(2), {0, 7});
  const auto one = Graph<SE2>(std::vector<SE2>(1), {0});
  EXPECT_EQ(ComparePosesUpToGauge(two, one).status().ToString(),
            "not found: node 7 is not in the reference");
  EXPECT_EQ(ComparePosesUpToGauge(one, two).status().ToString(),
            "not found: node 7 is not in the graph compared");
}

}  // namespace
}  // namespace hpgo
