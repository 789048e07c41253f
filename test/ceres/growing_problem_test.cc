// hpgo::ProblemSolver: a problem that grows, shrinks and is changed behind its back, kept near the
// optimum that ceres::Solve finds.
#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

#include "ceres/autodiff_cost_function.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/problem_solver.h"
#include "hpgo/replay.h"
#include "test/ceres/optimal_cost.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ::testing::HasSubstr;

struct Between {
  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    const T c = ceres::cos(a[2]), s = ceres::sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    r[0] = (c * dx + s * dy - z.data()[0]) * weight;
    r[1] = (-s * dx + c * dy - z.data()[1]) * weight;
    r[2] = ceres_costs::NormalizeAngle(T(b[2] - a[2] - z.data()[2])) * (3 * weight);
    return true;
  }
  static ceres::CostFunction* Make(const SE2& z, double weight = 10) {
    return new ceres::AutoDiffCostFunction<Between, 3, 3, 3>(new Between{z, weight});
  }
  SE2 z;
  double weight;
};

// A mapper that keeps its problem and calls Update at every keyframe.
class GrowingMap {
 public:
  GrowingMap(const PoseGraph<SE2>& graph, bool watch) : graph_(graph), steps_(ReplaySteps(graph)) {
    options_.watch = watch;
    solver_ = std::make_unique<ProblemSolver>(&problem_, options_);
  }

  // The next keyframe at its odometry, with its edges.
  void AddNode() {
    const int k = static_cast<int>(poses_.size());
    poses_.push_back({0, 0, 0});
    for (const int e : steps_[k].edges) {
      const GraphEdge<SE2>& edge = graph_.edges()[e];
      if (edge.i == k - 1) {
        const SE2 pose = SE2(poses_[k - 1].data()) * edge.measurement;
        std::copy_n(pose.data(), 3, poses_[k].data());
      }
      AddEdge(edge.i, edge.j, edge.measurement);
    }
    if (k == 1) solver_->SetParameterBlockConstant(poses_[0].data());
  }
  ceres::ResidualBlockId AddEdge(int i, int j, const SE2& z) {
    ceres::CostFunction* cost = Between::Make(z);
    ids_.push_back(
        options_.watch
            ? problem_.AddResidualBlock(cost, nullptr, poses_[i].data(), poses_[j].data())
            : solver_->AddResidualBlock(cost, nullptr, poses_[i].data(), poses_[j].data()));
    return ids_.back();
  }
  void RemoveEdge(ceres::ResidualBlockId id) {
    if (options_.watch) {
      problem_.RemoveResidualBlock(id);
    } else {
      solver_->RemoveResidualBlock(id);
    }
  }
  ProblemSolver& solver() { return *solver_; }
  ceres::Problem& problem() { return problem_; }
  std::vector<double>& pose(int k) { return poses_[k]; }
  std::vector<ceres::ResidualBlockId>& ids() { return ids_; }
  double Gap() { return CostOf(&problem_) / OptimalCost(&problem_) - 1; }

 private:
  const PoseGraph<SE2>& graph_;
  const std::vector<ReplayStep> steps_;
  ProblemSolverOptions options_;
  ceres::Problem problem_;
  std::unique_ptr<ProblemSolver> solver_;
  std::deque<std::vector<double>> poses_;  // whose data stays where it is
  std::vector<ceres::ResidualBlockId> ids_;
};

class ProblemSolverTest : public ::testing::TestWithParam<bool> {
 protected:
  const PoseGraph<SE2> graph_ = Graph<SE2>(200);
  GrowingMap map_{graph_, GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Watching, ProblemSolverTest, ::testing::Bool(), [](const auto& instance) {
  return instance.param ? "Watched" : "ThroughCalls";
});

TEST_P(ProblemSolverTest, GrowsNodeByNode) {
  map_.AddNode();
  for (int k = 1; k < 200; ++k) {
    map_.AddNode();
    ASSERT_TRUE(map_.solver().Update().status.ok());
    ASSERT_EQ(map_.solver().why_not_kept(), "");
    if (k % 50 == 49) {
      EXPECT_LE(map_.Gap(), 0.01) << k;
    }
  }
  ASSERT_TRUE(map_.solver().Refine().status.ok());
  EXPECT_LE(map_.Gap(), 1e-4);
  EXPECT_NEAR(map_.solver().Cost(), CostOf(&map_.problem()), 1e-6 * map_.solver().Cost());
  EXPECT_EQ(map_.pose(0), (std::vector<double>{0, 0, 0}));
}

TEST_P(ProblemSolverTest, TakesResidualsOutAndInAgain) {
  for (int k = 0; k < 120; ++k) map_.AddNode();
  map_.solver().Update();
  // A wrong closure comes, and goes.
  const ceres::ResidualBlockId wrong = map_.AddEdge(10, 100, SE2(1, 1, 1));
  map_.solver().Update();
  map_.solver().Refine();
  EXPECT_LE(map_.Gap(), 1e-3);
  map_.RemoveEdge(wrong);
  map_.solver().Refine();
  EXPECT_LE(map_.Gap(), 1e-3);
  ASSERT_EQ(map_.solver().why_not_kept(), "");
}

// The memory of a residual and its cost comes back for another between the same poses.
TEST_P(ProblemSolverTest, PointersThatRecurDoNotFoolIt) {
  for (int k = 0; k < 60; ++k) map_.AddNode();
  ceres::ResidualBlockId id = map_.AddEdge(5, 50, SE2(1, 2, 0.3));
  map_.solver().Refine();
  int recurred = 0;
  for (int k = 0; k < 8; ++k) {
    map_.RemoveEdge(id);
    const ceres::ResidualBlockId next = map_.AddEdge(5, 50, SE2(1 + 0.5 * k, 2, 0.3));
    recurred += next == id;
    id = next;
    map_.solver().Refine();
    EXPECT_LE(map_.Gap(), 1e-3) << k;
  }
  RecordProperty("recurred", recurred);
}

TEST_P(ProblemSolverTest, HoldsAndFreesPoses) {
  for (int k = 0; k < 80; ++k) map_.AddNode();
  map_.solver().Refine();
  map_.solver().SetParameterBlockConstant(map_.pose(40).data());
  map_.pose(40)[0] += 1;
  map_.solver().NoteChanged(map_.pose(40).data());
  const std::vector<double> held = map_.pose(40);
  map_.solver().Refine();
  EXPECT_EQ(map_.pose(40), held);
  EXPECT_LE(map_.Gap(), 1e-3);
  map_.solver().SetParameterBlockVariable(map_.pose(40).data());
  map_.solver().Refine();
  EXPECT_NE(map_.pose(40), held);
  EXPECT_LE(map_.Gap(), 1e-3);
}

TEST_P(ProblemSolverTest, TakesValuesWrittenFromOutside) {
  for (int k = 0; k < 80; ++k) map_.AddNode();
  map_.solver().Refine();
  for (int k = 30; k < 60; ++k) {
    map_.pose(k)[1] += 0.7;
    map_.solver().NoteChanged(map_.pose(k).data());
  }
  ASSERT_GT(map_.Gap(), 0.01);
  map_.solver().Refine();
  EXPECT_LE(map_.Gap(), 1e-3);
}

TEST_P(ProblemSolverTest, RemovesPoses) {
  for (int k = 0; k < 80; ++k) map_.AddNode();
  map_.solver().Update();
  if (GetParam()) {
    map_.problem().RemoveParameterBlock(map_.pose(30).data());
  } else {
    map_.solver().RemoveParameterBlock(map_.pose(30).data());
  }
  map_.AddEdge(29, 31, SE2(2, 0, 0));
  const std::vector<double> gone = map_.pose(30);
  map_.solver().Refine();
  ASSERT_EQ(map_.solver().why_not_kept(), "");
  EXPECT_EQ(map_.pose(30), gone);
  EXPECT_LE(map_.Gap(), 1e-3);
}

struct Curvature {
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* r) const {
    r[0] = a[0] + c[0] - T(2) * b[0];
    return true;
  }
};

TEST_P(ProblemSolverTest, ComesBackOnceAStrangerIsGone) {
  for (int k = 0; k < 40; ++k) map_.AddNode();
  map_.solver().Update();
  ASSERT_EQ(map_.solver().why_not_kept(), "");
  auto* cost = new ceres::AutoDiffCostFunction<Curvature, 1, 3, 3, 3>(new Curvature);
  std::vector<double*> blocks = {map_.pose(3).data(), map_.pose(4).data(), map_.pose(5).data()};
  const ceres::ResidualBlockId id = map_.solver().AddResidualBlock(cost, nullptr, blocks);
  EXPECT_TRUE(map_.solver().Update().status.ok());
  EXPECT_THAT(map_.solver().why_not_kept(), HasSubstr("spans 3 poses"));
  EXPECT_LE(map_.Gap(), 1e-3);
  map_.solver().RemoveResidualBlock(id);
  EXPECT_TRUE(map_.solver().Update().status.ok());
  EXPECT_EQ(map_.solver().why_not_kept(), "");
}

}  // namespace
}  // namespace hpgo
