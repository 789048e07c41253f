#include "hpgo/generate/synthetic_graph.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "Eigen/LU"
#include "ceres_costs/finite.h"
#include "glog/logging.h"
#include "hpgo/generate/random.h"
#include "hpgo/generate/revisits.h"
#include "hpgo/generate/true_path.h"

namespace hpgo {
namespace {

// How a place is recognized in each world. Rows of the sphere, the torus and the grid lie 1 m
// apart.
RevisitOptions RevisitsOf(World world) {
  switch (world) {
    case World::kSphere:
    case World::kTorus:
      return {1.5, 5, 1};
    case World::kGrid:
      return {1.1, 1.5, 2};
    case World::kManhattan:
      return {1.5, 10, 2};
    case World::kCity:
      return {2, 20, 1};
    case World::kTrajectory:
      break;
  }
  return {3, 20, 1};
}

// Picks about `density` a node of `candidates`, spread evenly over the time as far as there are
// any: a twentieth of the path after the other, each with the probability that makes up what is
// missing.
std::vector<Revisit> Thin(const std::vector<Revisit>& candidates, double density, int nodes,
                          Random random) {
  const int window = std::max(200, nodes / 20);
  std::vector<Revisit> kept;
  std::size_t first = 0;
  for (std::int64_t end = window; first < candidates.size(); end += window) {
    std::size_t last = first;
    while (last < candidates.size() && candidates[last].newer < end) ++last;
    const double wanted = density * static_cast<double>(std::min<std::int64_t>(end, nodes)) -
                          static_cast<double>(kept.size());
    const double share = wanted / static_cast<double>(std::max<std::size_t>(1, last - first));
    for (; first < last; ++first) {
      if (random.Uniform() < share) kept.push_back(candidates[first]);
    }
  }
  return kept;
}

// Exactly round(share * count) of 0 .. count - 1, each set as likely (Knuth's algorithm S).
std::vector<bool> ChooseExactly(double share, std::size_t count, Random random) {
  std::vector<bool> chosen(count, false);
  double wanted = std::round(share * static_cast<double>(count));
  for (std::size_t k = 0; k < count; ++k) {
    chosen[k] = random.Uniform() * static_cast<double>(count - k) < wanted;
    if (chosen[k]) --wanted;
  }
  return chosen;
}

// Makes measurements of true relative poses.
template <typename G>
class Sensor {
 public:
  explicit Sensor(const GenerateOptions& options)
      : dense_(options.dense_information), random_(options.seed, 4) {
    // The error's rotation is half the angle in 3D (g2o's convention).
    const double per_angle = G::kDim == 3 ? 0.5 : 1.0;
    const auto weighted = [](double sigma) {
      return sigma > 0 ? sigma : GenerateOptions::kExactSigma;
    };
    sigma_.template head<G::kDim>().setConstant(options.noise_translation);
    sigma_.template tail<G::kRotationDof>().setConstant(options.noise_rotation);
    inverse_.template head<G::kDim>().setConstant(1 / weighted(options.noise_translation));
    inverse_.template tail<G::kRotationDof>().setConstant(
        1 / (per_angle * weighted(options.noise_rotation)));
  }

  GraphEdge<G> Measure(int i, int j, const G& T_i_j) {
    const typename G::Matrix mixing = Mixing();
    typename G::Tangent n;
    for (int k = 0; k < G::kDof; ++k) n(k) = random_.Normal();
    n = sigma_.cwiseProduct(mixing * n);
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = j;
    edge.measurement = (T_i_j * G().Retract(n).Inverse()).Normalized();
    const typename G::Matrix root = mixing.inverse() * inverse_.asDiagonal();
    edge.information = root.transpose() * root;
    return edge;
  }

 private:
  // Unit rows: it correlates the axes and leaves the sigma of each.
  typename G::Matrix Mixing() {
    typename G::Matrix m = G::Matrix::Identity();
    if (!dense_) return m;
    for (int r = 1; r < G::kDof; ++r) {
      for (int c = 0; c < r; ++c) m(r, c) = random_.Uniform(-0.4, 0.4);
      m.row(r).normalize();
    }
    return m;
  }

  bool dense_;
  Random random_;
  typename G::Tangent sigma_;    // of the deviation: m, rad
  typename G::Tangent inverse_;  // 1 / sigma of the error, as weighted
};

// A place that looks like node `older` and is not: the farthest of a few older than `newer`.
template <typename G>
int WrongPlace(const std::vector<G>& truth, const Revisit& revisit, Random* random) {
  int wrong = revisit.older;
  double farthest = 0;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const int candidate = random->Below(revisit.newer);
    const double distance =
        (truth[candidate].translation() - truth[revisit.older].translation()).norm();
    if (candidate + 1 == revisit.newer || distance <= farthest) continue;
    wrong = candidate;
    farthest = distance;
  }
  return wrong;
}

template <typename G>
SyntheticGraph<G> Measure(std::vector<G> truth, const GenerateOptions& options, World world) {
  const double density =
      options.closure_density < 0 ? DefaultClosureDensity(world) : options.closure_density;
  RevisitOptions revisit_options = RevisitsOf(world);
  revisit_options.max_per_node =
      std::max(revisit_options.max_per_node, static_cast<int>(std::min(density + 1, 1e3)));
  const std::vector<Revisit> closures =
      Thin(FindRevisits(truth, revisit_options), density, static_cast<int>(truth.size()),
           Random(options.seed, 3));
  const std::vector<bool> wrong =
      ChooseExactly(options.outliers, closures.size(), Random(options.seed, 5));

  SyntheticGraph<G> result;
  result.closures = static_cast<int>(closures.size());
  result.graph.Reserve(truth.size(), truth.size() + closures.size());
  Sensor<G> sensor(options);
  Random outlier_random(options.seed, 6);
  std::size_t closure = 0;
  GraphNode<G> node;
  for (int k = 0; k < static_cast<int>(truth.size()); ++k) {
    node.id = k;
    GraphEdge<G> odometry;
    if (k > 0) {
      odometry = sensor.Measure(k - 1, k, truth[k - 1].Between(truth[k]));
      node.pose = (node.pose * odometry.measurement).Normalized();
    }
    CHECK(result.graph.AddNode(node).ok());
    if (k > 0) CHECK(result.graph.AddEdge(odometry).ok());
    for (; closure < closures.size() && closures[closure].newer == k; ++closure) {
      const int older = closures[closure].older;
      GraphEdge<G> edge = sensor.Measure(k, older, truth[k].Between(truth[older]));
      if (wrong[closure]) {
        edge.j = WrongPlace(truth, closures[closure], &outlier_random);
        result.outlier_edges.push_back(static_cast<int>(result.graph.edges().size()));
      }
      CHECK(result.graph.AddEdge(edge).ok());
    }
  }
  result.truth = std::move(truth);
  return result;
}

}  // namespace

template <typename G>
Result<SyntheticGraph<G>> GenerateGraph(const GenerateOptions& options) {
  if (Status status = CheckOptions(options, G::kDim); !status.ok()) return status;
  if (options.world == World::kTrajectory) {
    return Status(StatusCode::kInvalidArgument, "the trajectory world needs a trajectory");
  }
  return Measure(TruePoses<G>(options), options, options.world);
}

template <typename G>
Result<SyntheticGraph<G>> GenerateAlong(const std::vector<G>& poses,
                                        const GenerateOptions& options) {
  GenerateOptions along = options;
  along.world = World::kTrajectory;
  along.nodes = static_cast<int>(poses.size());
  if (poses.empty()) return Status(StatusCode::kInvalidArgument, "the trajectory has no poses");
  if (Status status = CheckOptions(along, G::kDim); !status.ok()) return status;
  const G T_first_world = poses.front().Inverse();
  std::vector<G> truth;
  truth.reserve(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    truth.push_back((T_first_world * poses[k]).Normalized());
    if (!IsFinite(truth.back())) {
      return Status(StatusCode::kInvalidArgument,
                    "pose " + std::to_string(k) + " of the trajectory is not finite");
    }
  }
  truth.front() = G();
  return Measure(std::move(truth), along, World::kTrajectory);
}

template <typename G>
PoseGraph<G> TruthGraph(const SyntheticGraph<G>& synthetic) {
  PoseGraph<G> graph;
  graph.Reserve(synthetic.truth.size(), 0);
  for (std::size_t k = 0; k < synthetic.truth.size(); ++k) {
    GraphNode<G> node;
    node.id = synthetic.graph.nodes()[k].id;
    node.pose = synthetic.truth[k];
    CHECK(graph.AddNode(node).ok());
  }
  return graph;
}

template Result<SyntheticGraph<SE2>> GenerateGraph<SE2>(const GenerateOptions&);
template Result<SyntheticGraph<SE3>> GenerateGraph<SE3>(const GenerateOptions&);
template Result<SyntheticGraph<SE2>> GenerateAlong(const std::vector<SE2>&, const GenerateOptions&);
template Result<SyntheticGraph<SE3>> GenerateAlong(const std::vector<SE3>&, const GenerateOptions&);
template PoseGraph<SE2> TruthGraph(const SyntheticGraph<SE2>&);
template PoseGraph<SE3> TruthGraph(const SyntheticGraph<SE3>&);

}  // namespace hpgo
