// Evaluations of costs: analytic and automatic, by the tangent and by the stored parameters.
//   cost_bench --benchmark_filter=SE3
#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "benchmark/benchmark.h"
#include "ceres/problem.h"
#include "ceres_costs/prior_cost.h"
#include "ceres_costs/relative_pose_cost.h"
#include "ceres_costs/whitening.h"

namespace ceres_costs {
namespace {

constexpr int kCosts = 256;  // fits the caches, defeats branch prediction by heart

// Deviations as a graph near its optimum has them.
template <typename G>
G RandomPose(std::mt19937* rng, double distance, double angle) {
  std::normal_distribution<double> normal;
  typename G::Tangent d;
  for (int k = 0; k < G::kDof; ++k) d(k) = normal(*rng);
  d.template head<G::kDim>() *= distance;
  d.template tail<G::kRotationDof>() *= angle;
  return G().Retract(d);
}

template <typename G>
typename G::Matrix RandomInformation(std::mt19937* rng) {
  std::normal_distribution<double> normal;
  const typename G::Matrix m = G::Matrix::NullaryExpr([&] { return normal(*rng); });
  return m * m.transpose() + G::Matrix::Identity();
}

// Measurements between random poses, and a block of parameters an end.
template <typename G>
struct Sample {
  std::vector<G> poses;  // those of cost k are 2k and 2k + 1
  std::vector<RelativePoseTerm<G>> terms;
};

template <typename G>
Sample<G> MakeSample() {
  std::mt19937 rng(42);
  Sample<G> sample;
  for (int k = 0; k < kCosts; ++k) {
    const G X_i = RandomPose<G>(&rng, 50, 1), Z = RandomPose<G>(&rng, 1, 0.3);
    sample.poses.push_back(X_i);
    sample.poses.push_back(X_i * Z * RandomPose<G>(&rng, 0.05, 0.02));
    sample.terms.push_back({Z, PackedSymmetric<G::kDof>(RandomInformation<G>(&rng))});
  }
  return sample;
}

template <typename G>
struct Buffers {
  double residuals[G::kDof];
  double jacobian_i[G::kDof * G::kParams];
  double jacobian_j[G::kDof * G::kParams];
};

// One evaluation: residuals and both Jacobians.
template <typename G, DiffMethod method, JacobianKind kind, ErrorConvention convention>
void RelativePose(benchmark::State& state) {
  const Sample<G> sample = MakeSample<G>();
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;
  for (const RelativePoseTerm<G>& term : sample.terms) {
    std::string error;
    costs.push_back(MakeRelativePoseCost(term, convention, method, kind, &error));
    if (costs.back() == nullptr) return state.SkipWithError(error.c_str());
  }
  Buffers<G> buffers;
  double* jacobians[] = {buffers.jacobian_i, buffers.jacobian_j};
  int k = 0;
  for (auto _ : state) {
    const double* parameters[] = {sample.poses[2 * k].data(), sample.poses[2 * k + 1].data()};
    benchmark::DoNotOptimize(costs[k]->Evaluate(parameters, buffers.residuals, jacobians));
    benchmark::ClobberMemory();
    k = (k + 1) % kCosts;
  }
  state.SetItemsProcessed(state.iterations());
}

template <typename G, DiffMethod method, JacobianKind kind>
void Prior(benchmark::State& state) {
  const Sample<G> sample = MakeSample<G>();
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;
  for (int k = 0; k < kCosts; ++k) {
    std::string error;
    costs.push_back(MakePriorCost(sample.terms[k], &sample.poses[2 * k], ErrorConvention::kG2o,
                                  method, kind, &error));
    if (costs.back() == nullptr) return state.SkipWithError(error.c_str());
  }
  Buffers<G> buffers;
  double* jacobians[] = {buffers.jacobian_i};
  int k = 0;
  for (auto _ : state) {
    const double* parameters[] = {sample.poses[2 * k + 1].data()};
    benchmark::DoNotOptimize(costs[k]->Evaluate(parameters, buffers.residuals, jacobians));
    benchmark::ClobberMemory();
    k = (k + 1) % kCosts;
  }
  state.SetItemsProcessed(state.iterations());
}

// What Ceres makes of it: residuals and the sparse Jacobian of a whole problem, manifolds included,
// per cost.
template <typename G, DiffMethod method, JacobianKind kind, ErrorConvention convention>
void Problem(benchmark::State& state) {
  Sample<G> sample = MakeSample<G>();
  ceres::Problem problem;
  std::vector<std::array<double, G::kParams>> poses(sample.poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    std::copy_n(sample.poses[k].data(), G::kParams, poses[k].data());
    problem.AddParameterBlock(poses[k].data(), G::kParams, MakePoseManifold<G>(kind).release());
  }
  for (int k = 0; k < kCosts; ++k) {
    std::string error;
    auto cost = MakeRelativePoseCost(sample.terms[k], convention, method, kind, &error);
    if (cost == nullptr) return state.SkipWithError(error.c_str());
    problem.AddResidualBlock(cost.release(), nullptr, poses[2 * k].data(), poses[2 * k + 1].data());
  }
  std::vector<double> residuals(G::kDof * kCosts), gradient(2 * G::kDof * kCosts);
  for (auto _ : state) {
    double total = 0;
    benchmark::DoNotOptimize(problem.Evaluate(ceres::Problem::EvaluateOptions(), &total, &residuals,
                                              &gradient, nullptr));
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kCosts);
}

template <typename G>
void Reset(benchmark::State& state) {
  const Sample<G> sample = MakeSample<G>();
  RelativePoseCost<G> cost;
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cost.Reset(sample.terms[k], ErrorConvention::kG2o));
    benchmark::ClobberMemory();
    k = (k + 1) % kCosts;
  }
}

template <typename G>
void Classify(benchmark::State& state) {
  const Sample<G> sample = MakeSample<G>();
  std::vector<typename G::Matrix> matrices;
  for (const auto& term : sample.terms) matrices.push_back(term.information.Dense());
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ClassifyInformation<G::kDof>(matrices[k]));
    k = (k + 1) % kCosts;
  }
}

constexpr auto kAnalytic = DiffMethod::kAnalytic;
constexpr auto kAutomatic = DiffMethod::kAutomatic;
constexpr auto kLocal = JacobianKind::kLocal;
constexpr auto kAmbient = JacobianKind::kAmbient;
constexpr auto kG2o = ErrorConvention::kG2o;
constexpr auto kTwist = ErrorConvention::kTwist;
constexpr auto kSplitLog = ErrorConvention::kSplitLog;

BENCHMARK_TEMPLATE(RelativePose, SE2, kAnalytic, kLocal, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE2, kAnalytic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE2, kAutomatic, kLocal, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE2, kAutomatic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE2, kAnalytic, kLocal, kTwist);
BENCHMARK_TEMPLATE(RelativePose, SE2, kAutomatic, kAmbient, kTwist);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAnalytic, kLocal, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAnalytic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAutomatic, kLocal, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAutomatic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAnalytic, kLocal, kTwist);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAutomatic, kAmbient, kTwist);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAnalytic, kLocal, kSplitLog);
BENCHMARK_TEMPLATE(RelativePose, SE3, kAutomatic, kAmbient, kSplitLog);
BENCHMARK_TEMPLATE(Prior, SE2, kAnalytic, kLocal);
BENCHMARK_TEMPLATE(Prior, SE2, kAutomatic, kAmbient);
BENCHMARK_TEMPLATE(Prior, SE3, kAnalytic, kLocal);
BENCHMARK_TEMPLATE(Prior, SE3, kAutomatic, kAmbient);
BENCHMARK_TEMPLATE(Problem, SE2, kAnalytic, kLocal, kG2o);
BENCHMARK_TEMPLATE(Problem, SE2, kAnalytic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(Problem, SE2, kAutomatic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(Problem, SE3, kAnalytic, kLocal, kG2o);
BENCHMARK_TEMPLATE(Problem, SE3, kAnalytic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(Problem, SE3, kAutomatic, kAmbient, kG2o);
BENCHMARK_TEMPLATE(Problem, SE3, kAnalytic, kLocal, kTwist);
BENCHMARK_TEMPLATE(Problem, SE3, kAutomatic, kAmbient, kTwist);
BENCHMARK_TEMPLATE(Reset, SE2);
BENCHMARK_TEMPLATE(Reset, SE3);
BENCHMARK_TEMPLATE(Classify, SE2);
BENCHMARK_TEMPLATE(Classify, SE3);

}  // namespace
}  // namespace ceres_costs
