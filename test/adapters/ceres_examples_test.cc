// Ceres' example types, growing.

#include "hpgo/adapters/ceres_examples.h"

#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "Eigen/StdVector"
#include "test/adapters/real_graphs.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

// The types as the examples have them.
struct Pose2d {
  double x, y, yaw_radians;
};
struct Constraint2d {
  int id_begin, id_end;
  double x, y, yaw_radians;
  Eigen::Matrix3d information;
};
struct Pose3d {
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
};
struct Constraint3d {
  int id_begin, id_end;
  Pose3d t_be;
  Eigen::Matrix<double, 6, 6> information;
};
template <typename Pose>
using Poses =
    std::map<int, Pose, std::less<int>, Eigen::aligned_allocator<std::pair<const int, Pose>>>;
template <typename Constraint>
using Constraints = std::vector<Constraint, Eigen::aligned_allocator<Constraint>>;

Pose2d ToPose(const SE2& X) { return {X.data()[0], X.data()[1], X.angle()}; }
Pose3d ToPose(const SE3& X) { return {X.translation(), X.rotation()}; }

// The examples' residuals.
Eigen::Vector3d Residual(const Pose2d& a, const Pose2d& b, const Constraint2d& c) {
  const Eigen::Rotation2Dd R(a.yaw_radians);
  const Eigen::Vector2d t = R.inverse() * Eigen::Vector2d(b.x - a.x, b.y - a.y);
  return Eigen::Vector3d(
      t(0) - c.x, t(1) - c.y,
      std::remainder(b.yaw_radians - a.yaw_radians - c.yaw_radians, 2 * 3.141592653589793));
}
Eigen::Matrix<double, 6, 1> Residual(const Pose3d& a, const Pose3d& b, const Constraint3d& c) {
  const Eigen::Quaterniond q_ab = a.q.conjugate() * b.q;
  const Eigen::Quaterniond delta = c.t_be.q * q_ab.conjugate();
  Eigen::Matrix<double, 6, 1> e;
  e << a.q.conjugate() * (b.p - a.p) - c.t_be.p, (delta.w() < 0 ? -2. : 2.) * delta.vec();
  return e;
}
Constraint2d MakeConstraint(int i, int j, const SE2& Z, const Eigen::Matrix3d& information) {
  return {i, j, Z.data()[0], Z.data()[1], Z.angle(), information};
}
Constraint3d MakeConstraint(int i, int j, const SE3& Z,
                            const Eigen::Matrix<double, 6, 6>& information) {
  return {i, j, ToPose(Z), information};
}

template <typename G>
struct TypesOf;
template <>
struct TypesOf<SE2> {
  using Map = Poses<Pose2d>;
  using Vector = Constraints<Constraint2d>;
};
template <>
struct TypesOf<SE3> {
  using Map = Poses<Pose3d>;
  using Vector = Constraints<Constraint3d>;
};
template <typename G>
using Problem = CeresExampleProblem<G, typename TypesOf<G>::Map, typename TypesOf<G>::Vector>;

template <typename G>
double ExampleCost(const typename TypesOf<G>::Vector& constraints,
                   const typename TypesOf<G>::Map& poses) {
  double cost = 0;
  for (const auto& c : constraints) {
    const auto e = Residual(poses.at(c.id_begin), poses.at(c.id_end), c);
    cost += e.dot(c.information * e);
  }
  return cost;
}

template <typename G>
void ExpectOptimum(const std::string& name) {
  const PoseGraph<G> graph = RealGraph<G>(name);
  if (graph.nodes().empty()) GTEST_SKIP() << "no " << name;
  Problem<G> problem;
  typename TypesOf<G>::Map poses;
  typename TypesOf<G>::Vector constraints;
  const int n = static_cast<int>(graph.nodes().size());
  double ms = 0;
  PoseGraph<G> before = graph;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    const int k = step.node;
    poses[k] = ToPose(*StartPose<G>(graph, step, [&](int node) -> Result<G> {
      return ToGroup(poses.at(node), static_cast<G*>(nullptr));
    }));
    for (const int e : step.edges) {
      const auto& edge = graph.edges()[e];
      constraints.push_back(MakeConstraint(edge.i, edge.j, edge.measurement, edge.information));
    }
    if ((k + 1) % (n / 10) != 0 && k + 1 != n) continue;
    for (int m = 0; m <= k; ++m)
      before.node(m).pose = ToGroup(poses.at(m), static_cast<G*>(nullptr));
    const double start = CpuMilliseconds();
    const UpdateReport report = problem.Solve(constraints, &poses);
    ms = CpuMilliseconds() - start;
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
  }
  EXPECT_LT(Gap(problem.optimizer()), 1e-6);
  const double cost = ExampleCost<G>(constraints, poses);
  EXPECT_NEAR(cost, problem.optimizer().Cost(), 1e-6 * cost);
  std::printf("%s: the last Solve %.1f ms of CPU time, ceres::Solve of the same %.1f ms\n",
              name.c_str(), ms, CeresMilliseconds(before));
  EXPECT_EQ(problem.Solve(constraints, &poses).windows, 0);  // nothing has changed
}

TEST(CeresExamplesTest, M3500) { ExpectOptimum<SE2>("g2o/M3500.g2o"); }
TEST(CeresExamplesTest, Intel) { ExpectOptimum<SE2>("g2o/intel.g2o"); }
TEST(CeresExamplesTest, Kitti00) { ExpectOptimum<SE2>("kitti/graphs/kitti_00.g2o"); }
TEST(CeresExamplesTest, City2d) { ExpectOptimum<SE2>("city 10000"); }
TEST(CeresExamplesTest, City3d) { ExpectOptimum<SE3>("city 3000"); }
TEST(CeresExamplesTest, ParkingGarage) { ExpectOptimum<SE3>("g2o/parking-garage.g2o"); }

template <typename G>
class CeresExampleTypesTest : public testing::Test {};
using BothGroups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(CeresExampleTypesTest, BothGroups);

// Dense information: the frames and the scale of the errors matter.
TYPED_TEST(CeresExampleTypesTest, TheObjectiveIsTheExamples) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(60, 0.2, 3);
  Problem<G> problem;
  typename TypesOf<G>::Map poses;
  typename TypesOf<G>::Vector constraints;
  for (int k = 0; k < 60; ++k) poses[k] = ToPose(known.graph.nodes()[k].pose);
  for (const auto& edge : known.graph.edges()) {
    constraints.push_back(MakeConstraint(edge.i, edge.j, edge.measurement, edge.information));
  }
  const auto first = poses[0];
  ASSERT_TRUE(problem.Solve(constraints, &poses).status.ok());
  const double cost = ExampleCost<G>(constraints, poses);
  EXPECT_NEAR(problem.optimizer().Cost(), cost, 1e-9 * cost);
  EXPECT_LT(Gap(problem.optimizer()), 1e-9);
  EXPECT_LT(ToGroup(first, static_cast<G*>(nullptr))
                .LocalCoordinates(ToGroup(poses[0], static_cast<G*>(nullptr)))
                .norm(),
            1e-12);
  // A constraint fewer and a node fewer: anew.
  const int last_end = constraints.back().id_end;
  constraints.pop_back();
  ASSERT_TRUE(problem.Solve(constraints, &poses).status.ok());
  EXPECT_EQ(problem.optimizer().num_edges(), constraints.size());
  // An error names the edge and leaves the poses.
  constraints.push_back(constraints.back());
  constraints.back().id_end = 1000;
  const auto before = ExampleCost<G>(
      typename TypesOf<G>::Vector(constraints.begin(), constraints.end() - 1), poses);
  EXPECT_EQ(problem.Solve(constraints, &poses).status.message(),
            "edge " + std::to_string(constraints.back().id_begin) + " -> 1000: no node 1000");
  constraints.back().id_end = last_end;
  EXPECT_EQ(before,
            ExampleCost<G>(typename TypesOf<G>::Vector(constraints.begin(), constraints.end() - 1),
                           poses));
  EXPECT_TRUE(problem.Solve(constraints, &poses).status.ok());
}

// The map is held at the first pose of the client, who may move it, or add one before it.
TYPED_TEST(CeresExampleTypesTest, TheFirstPoseIsTheClients) {
  using G = TypeParam;
  Problem<G> problem;
  typename TypesOf<G>::Map poses;
  typename TypesOf<G>::Vector constraints;
  G step;
  step.translation()(0) = 1;
  for (int k = 0; k < 3; ++k) poses[k] = ToPose(G());
  for (int k = 1; k < 3; ++k) {
    constraints.push_back(MakeConstraint(k - 1, k, step, G::Matrix::Identity()));
  }
  const auto x = [&](int k) {
    return ToGroup(poses.at(k), static_cast<G*>(nullptr)).translation()(0);
  };
  ASSERT_TRUE(problem.Solve(constraints, &poses).status.ok());
  EXPECT_EQ(x(0), 0);
  EXPECT_NEAR(x(2), 2, 1e-9);
  G moved;
  moved.translation()(0) = 10;
  poses[0] = ToPose(moved);
  ASSERT_TRUE(problem.Solve(constraints, &poses).status.ok());
  EXPECT_EQ(x(0), 10);
  EXPECT_NEAR(x(2), 12, 1e-9);
  poses[-1] = ToPose(G());
  constraints.push_back(MakeConstraint(-1, 0, step, G::Matrix::Identity()));
  ASSERT_TRUE(problem.Solve(constraints, &poses).status.ok());
  EXPECT_EQ(x(-1), 0);
  EXPECT_NEAR(x(0), 1, 1e-9);
  EXPECT_NEAR(x(2), 3, 1e-9);
}

}  // namespace
}  // namespace hpgo
