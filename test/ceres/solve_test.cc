// hpgo::Solve against ceres::Solve on the problems of mappers.
#include "hpgo/ceres/solve.h"

#include <cmath>
#include <cstring>
#include <string>
#include <variant>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_reader.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ::testing::HasSubstr;
using ::testing::StartsWith;

ceres::Solver::Options ToConvergence() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;  // some robust losses take Ceres thousands
  options.function_tolerance = 1e-10;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  return options;
}

template <typename G>
PoseGraph<G> City(int nodes) {
  GenerateOptions options;
  options.world = World::kCity;
  options.nodes = nodes;
  options.closure_density = 0.05;
  return GenerateGraph<G>(options)->graph;
}

// The same problem twice, solved by each; `mapper` decides how it is built.
template <typename Mapper, typename G>
void ExpectAsGood(Mapper mapper, const PoseGraph<G>& graph) {
  const std::unique_ptr<MapperProblem> ours = MakeMapperProblem(mapper, graph);
  const std::unique_ptr<MapperProblem> theirs = MakeMapperProblem(mapper, graph);
  const std::vector<std::vector<double>> before = ours->storage, extra = ours->extra;
  ceres::Solver::Summary summary, reference;
  hpgo::Solve(ToConvergence(), ours->problem.get(), &summary);
  ceres::Solve(ToConvergence(), theirs->problem.get(), &reference);
  ASSERT_TRUE(reference.IsSolutionUsable()) << reference.FullReport();
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.FullReport();
  EXPECT_THAT(summary.message, StartsWith("hpgo: ")) << summary.FullReport();
  EXPECT_THAT(summary.message, ::testing::Not(HasSubstr("left to"))) << summary.FullReport();
  EXPECT_NEAR(summary.initial_cost, reference.initial_cost, 1e-9 * reference.initial_cost);
  EXPECT_LE(summary.final_cost, reference.final_cost * (1 + 1e-6)) << summary.FullReport();
  // Damping that is in the way, or comes and goes, took ten times as many.
  EXPECT_LE(summary.iterations.size(), 2 * reference.iterations.size() + 5);
  // The summary tells the truth of what was written.
  double cost = 0;
  ASSERT_TRUE(ours->problem->Evaluate({}, &cost, nullptr, nullptr, nullptr));
  EXPECT_NEAR(summary.final_cost, cost, 1e-9 * cost);
  std::vector<double*> blocks;
  ours->problem->GetParameterBlocks(&blocks);
  for (std::size_t p = 0; p < ours->storage.size(); ++p) {
    for (std::size_t k = 0; k < ours->sizes[p].size(); ++k) {
      double* block = ours->Block(static_cast<int>(p), static_cast<int>(k));
      if (!ours->problem->HasParameterBlock(block) ||
          !ours->problem->IsParameterBlockConstant(block)) {
        continue;
      }
      const double* was = before[p].data() + (block - ours->storage[p].data());
      EXPECT_EQ(std::memcmp(block, was, sizeof(double) * ours->sizes[p][k]), 0)
          << "pose " << p << ", block " << k;
    }
  }
  EXPECT_EQ(ours->extra, extra);
}

// The file's graph; skips where the data is not there.
#define READ_OR_SKIP(G, graph, name)                                                   \
  Result<AnyGraphFile> graph##_file =                                                  \
      ReadG2o(std::string(HPGO_SHARED_DATA_DIR) + "/" + name, ReadOptions(), nullptr); \
  if (!graph##_file.ok() && graph##_file.status().code() == StatusCode::kUnreadable) { \
    GTEST_SKIP() << graph##_file.status().ToString();                                  \
  }                                                                                    \
  ASSERT_TRUE(graph##_file.ok()) << graph##_file.status().ToString();                  \
  const PoseGraph<G>& graph = std::get<GraphFile<G>>(*graph##_file).graph

class Mapper2dTest : public ::testing::TestWithParam<Mapper2d> {};
TEST_P(Mapper2dTest, City) { ExpectAsGood(GetParam(), City<SE2>(400)); }
TEST_P(Mapper2dTest, M3500) {
  READ_OR_SKIP(SE2, graph, "g2o/M3500.g2o");
  ExpectAsGood(GetParam(), graph);
}
TEST_P(Mapper2dTest, Intel) {
  READ_OR_SKIP(SE2, graph, "g2o/intel.g2o");
  ExpectAsGood(GetParam(), graph);
}
TEST_P(Mapper2dTest, Kitti00) {
  READ_OR_SKIP(SE2, graph, "kitti/graphs/kitti_00.g2o");
  ExpectAsGood(GetParam(), graph);
}
INSTANTIATE_TEST_SUITE_P(Mappers, Mapper2dTest, ::testing::ValuesIn(kMappers2d),
                         [](const auto& instance) { return MapperName(instance.param); });

class Mapper3dTest : public ::testing::TestWithParam<Mapper3d> {};
TEST_P(Mapper3dTest, City) { ExpectAsGood(GetParam(), City<SE3>(300)); }
TEST_P(Mapper3dTest, Sphere2500) {
  READ_OR_SKIP(SE3, graph, "g2o/sphere2500.g2o");
  ExpectAsGood(GetParam(), graph);
}
INSTANTIATE_TEST_SUITE_P(Mappers, Mapper3dTest, ::testing::ValuesIn(kMappers3d),
                         [](const auto& instance) { return MapperName(instance.param); });

}  // namespace
}  // namespace hpgo
