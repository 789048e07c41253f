// Edges with a caller's own Ceres cost.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "ceres/autodiff_cost_function.h"
#include "ceres/sized_cost_function.h"
#include "ceres_costs/common_motion.h"
#include "gtest/gtest.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

// The built-in error of a relative pose, in 2D and with an information that is diagonal, as anybody
// would write it.
struct PlanarError {
  SE2 measurement;
  Eigen::Vector3d weights;  // roots of the information's diagonal
  template <typename T>
  bool operator()(const T* i, const T* j, T* residual) const {
    const T c = ceres::cos(i[2]), s = ceres::sin(i[2]), dx = j[0] - i[0], dy = j[1] - i[1];
    const T x = c * dx + s * dy - measurement.data()[0];
    const T y = -s * dx + c * dy - measurement.data()[1];
    const double cz = std::cos(measurement.angle()), sz = std::sin(measurement.angle());
    residual[0] = weights(0) * (cz * x + sz * y);
    residual[1] = weights(1) * (-sz * x + cz * y);
    residual[2] = weights(2) * ceres_costs::NormalizeAngle(j[2] - i[2] - measurement.angle());
    return true;
  }
};

// |p_i - p_j| - distance, as long as it is defined at all.
class Distance : public ceres::SizedCostFunction<1, 3, 3> {
 public:
  explicit Distance(double distance) : distance_(distance) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Eigen::Map<const Eigen::Vector2d> i(x[0]), j(x[1]);
    const double d = (j - i).norm();
    *r = d - distance_;
    for (int k = 0; k < 2 && J != nullptr; ++k) {
      if (J[k] == nullptr) continue;
      Eigen::Map<Eigen::RowVector3d> row(J[k]);
      row << (k == 0 ? -1 : 1) * (j - i).transpose() / d, 0;
    }
    return defined;
  }
  bool defined = true;

 private:
  const double distance_;
};

class CustomCostTest : public testing::TestWithParam<Engine> {
 protected:
  static OptimizerOptions Options() {
    OptimizerOptions options;
    options.engine = GetParam();
    options.max_top_nodes = 8;
    options.window_nodes = 12;
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Engines, CustomCostTest, testing::Values(Engine::kCeres, Engine::kBlock),
                         [](const auto& engine) {
                           return std::string(engine.param == Engine::kCeres ? "Ceres" : "Block");
                         });

TEST_P(CustomCostTest, GivesTheSameAsTheBuiltInEdge) {
  const KnownGraph<SE2> known = MakeKnownGraph<SE2>(60, 0.1, 4);
  const Eigen::Vector3d weights(3, 2, 5);
  const Eigen::Matrix3d information = weights.cwiseAbs2().asDiagonal();
  Optimizer2d built_in(Options()), custom(Options());
  for (Optimizer2d* optimizer : {&built_in, &custom}) {
    std::size_t next = 0;
    for (int k = 0; k < 60; ++k) {
      ASSERT_TRUE(optimizer->AddNode(k, known.graph.nodes()[k].pose).ok());
      if (k > 0) {
        const GraphEdge<SE2>& edge = known.graph.edges()[next++];
        ASSERT_TRUE(optimizer->AddEdge(k - 1, k, edge.measurement, information).ok());
      }
      optimizer->Update();
    }
    for (; next < known.graph.edges().size(); ++next) {
      const GraphEdge<SE2>& edge = known.graph.edges()[next];
      auto cost = std::make_shared<ceres::AutoDiffCostFunction<PlanarError, 3, 3, 3>>(
          new PlanarError{edge.measurement, weights});
      const Result<EdgeId> id =
          optimizer == &custom
              ? optimizer->AddCustomEdge(edge.i, edge.j, cost, edge.measurement, information)
              : optimizer->AddEdge(edge.i, edge.j, edge.measurement, information);
      ASSERT_TRUE(id.ok()) << id.status().ToString();
      EXPECT_TRUE(optimizer->Update().status.ok());
    }
    EXPECT_TRUE(optimizer->Refine().at_rest);
  }
  EXPECT_NEAR(custom.Cost(), built_in.Cost(), 1e-6 * built_in.Cost());
  EXPECT_LT(Gap(built_in), 1e-4);
  for (int k = 0; k < 60; ++k) {
    EXPECT_LT(built_in.GetPose(k)->LocalCoordinates(*custom.GetPose(k)).norm(), 1e-5) << k;
  }
}

TEST_P(CustomCostTest, ThatCannotBeEvaluatedIsReportedAndChangesNothing) {
  Optimizer2d optimizer(Options());
  ASSERT_TRUE(optimizer.AddNode(4, SE2()).ok());
  ASSERT_TRUE(optimizer.AddNode(5, SE2(1, 0, 0)).ok());
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const auto cost = std::make_shared<Distance>(2);
  const EdgeId bad = *optimizer.AddCustomEdge(4, 5, cost, SE2(1, 0, 0), I);
  cost->defined = false;
  ASSERT_TRUE(optimizer.AddEdge(4, 5, SE2(2, 0, 0), I).ok());
  const UpdateReport report = optimizer.Update();
  EXPECT_EQ(report.status.code(), StatusCode::kNoSolution);
  EXPECT_EQ(report.status.message(), "edge 4 -> 5: its cost cannot be evaluated at the estimate");
  EXPECT_EQ(optimizer.GetPose(5)->data()[0], 1);
  // And again when something near it is to be solved.
  ASSERT_TRUE(optimizer.AddEdge(4, 5, SE2(3, 0, 0), I).ok());
  EXPECT_EQ(optimizer.Update().status.message(),
            "edge 4 -> 5: its cost cannot be evaluated at the estimate");
  EXPECT_EQ(optimizer.GetPose(5)->data()[0], 1);
  EXPECT_TRUE(std::isnan(optimizer.Cost()));
  // Without it all is well.
  ASSERT_TRUE(optimizer.RemoveEdge(bad).ok());
  EXPECT_TRUE(optimizer.Refine().status.ok());
  EXPECT_NEAR(optimizer.GetPose(5)->data()[0], 2.5, 1e-6);
}

TEST(CustomCostErrorsTest, WrongSizesAndUpdatesAreRefused) {
  Optimizer3d optimizer;
  ASSERT_TRUE(optimizer.AddNode(4, SE3()).ok());
  ASSERT_TRUE(optimizer.AddNode(5, SE3()).ok());
  const SE3::Matrix I = SE3::Matrix::Identity();
  const std::string message = "edge 4 -> 5: the cost is not over two poses";
  Status status = optimizer.AddCustomEdge(4, 5, std::make_shared<Distance>(2), SE3(), I).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), message);
  EXPECT_EQ(optimizer.AddCustomEdge(4, 5, nullptr, SE3(), I).status().message(), message);
  EXPECT_EQ(optimizer.num_edges(), 0u);

  Optimizer2d planar;
  ASSERT_TRUE(planar.AddNode(4, SE2()).ok());
  ASSERT_TRUE(planar.AddNode(5, SE2()).ok());
  const auto cost = std::make_shared<Distance>(2);
  const EdgeId edge = *planar.AddCustomEdge(4, 5, cost, SE2(), Eigen::Matrix3d::Identity());
  status = planar.UpdateEdge(edge, SE2(), Eigen::Matrix3d::Identity());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(),
            "edge 4 -> 5: its cost is the caller's own; remove it and add another");
}

// What the world's axes or origin have a part in.
struct InTheWorld {
  enum Kind { kShift, kPlace, kHeading, kTilt } kind;
  template <typename T>
  bool operator()(const T* i, const T* j, T* residual) const {
    if (kind == kShift) residual[0] = j[0] - i[0] - 1.;
    if (kind == kPlace) residual[0] = j[0] + i[1] - 1.;
    if (kind == kHeading) residual[0] = 1e-2 * j[2] + ceres::cos(j[2] - i[2]);
    if (kind == kTilt) residual[0] = ceres::sin(j[2]);
    return true;
  }
};

TEST(CustomCostErrorsTest, MoreThanTheRelativePoseIsRefused) {
  Optimizer2d optimizer;
  ASSERT_TRUE(optimizer.AddNode(4, SE2()).ok());
  ASSERT_TRUE(optimizer.AddNode(5, SE2(1, 2, 3)).ok());
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for (const auto kind :
       {InTheWorld::kShift, InTheWorld::kPlace, InTheWorld::kHeading, InTheWorld::kTilt}) {
    const auto cost =
        std::make_shared<ceres::AutoDiffCostFunction<InTheWorld, 1, 3, 3>>(new InTheWorld{kind});
    const Status status = optimizer.AddCustomEdge(4, 5, cost, SE2(), I).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(status.message().find("edge 4 -> 5: its cost depends on more than T_i_j: "), 0u)
        << kind << " " << status.message();
  }
  const auto never = std::make_shared<Distance>(2);
  never->defined = false;
  EXPECT_EQ(optimizer.AddCustomEdge(4, 5, never, SE2(), I).status().message(),
            "edge 4 -> 5: its cost cannot be evaluated at the estimate");
  EXPECT_EQ(optimizer.num_edges(), 0u);
}

TEST(CustomCostErrorsTest, WeightsAndFarPlacesAreNoReason) {
  for (const double weight : {1e-6, 1., 1e6}) {
    for (const double angle : {-3.1, 0., 1., 3.1}) {
      const SE2 measurement(30, -200, angle);
      const auto cost = std::make_shared<ceres::AutoDiffCostFunction<PlanarError, 3, 3, 3>>(
          new PlanarError{measurement, Eigen::Vector3d(weight, 2, 1 / weight)});
      EXPECT_EQ(ceres_costs::CommonMotionProblem(*cost, measurement), "") << weight << " " << angle;
      EXPECT_EQ(ceres_costs::CommonMotionProblem(*cost, SE2(1, 0, -angle)), "")
          << weight << " " << angle;
    }
  }
}

}  // namespace
}  // namespace hpgo
