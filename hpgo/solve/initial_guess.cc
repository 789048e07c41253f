#include "hpgo/solve/initial_guess.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "ceres_costs/symmetric_eigen.h"
#include "hpgo/graph/components.h"
#include "hpgo/solve/chordal.h"
#include "hpgo/solve/initial_guess_rotation.h"
#include "hpgo/solve/initial_guess_tree.h"
#include "hpgo/solve/joint_chordal.h"

namespace hpgo {
namespace {

struct NamedMethod {
  InitMethod method;
  const char* name;
};
constexpr NamedMethod kNames[] = {{InitMethod::kFile, "file"},
                                  {InitMethod::kOdometry, "odometry"},
                                  {InitMethod::kSpanningTree, "spanning_tree"},
                                  {InitMethod::kChordal, "chordal"},
                                  {InitMethod::kJointChordal, "joint_chordal"},
                                  {InitMethod::kAuto, "auto"}};

// Costs closer than this, relative to one another, are a tie.
constexpr double kTie = 1e-6;

template <typename G>
bool MeasuresPosition(const GraphPrior<G>& prior) {
  const auto values = ceres_costs::EigenvaluesOf<G::kDim>(
      prior.information.template topLeftCorner<G::kDim, G::kDim>());
  return values(0) > 1e-12 * values(G::kDim - 1);
}

// The rigid motion that brings the points `from` nearest to `to` (Kabsch).
template <typename G>
G RigidMotion(const std::vector<typename G::Vector>& from,
              const std::vector<typename G::Vector>& to) {
  using Vector = typename G::Vector;
  using Rotation = typename G::RotationMatrix;
  const double count = static_cast<double>(from.size());
  const Vector from_mean =
      std::accumulate(from.begin(), from.end(), Vector(Vector::Zero())) / count;
  const Vector to_mean = std::accumulate(to.begin(), to.end(), Vector(Vector::Zero())) / count;
  Rotation correlation = Rotation::Zero();
  for (std::size_t k = 0; k < from.size(); ++k) {
    correlation += (to[k] - to_mean) * (from[k] - from_mean).transpose();
  }
  G motion;
  SetNearestRotation(correlation, Rotation::Identity(), &motion);
  motion.translation() = to_mean - motion.matrix() * from_mean;
  return motion;
}

// Moves each component that has no firm anchor rigidly onto its position priors.
template <typename G>
void AlignToPriors(const PoseGraph<G>& graph, const Components& components,
                   const std::vector<Anchor<G>>& anchors, std::vector<G>* poses) {
  if (graph.priors().empty()) return;
  std::vector<bool> movable(components.count, false);
  for (const Anchor<G>& anchor : anchors) {
    movable[components.of_node[anchor.node]] = !anchor.firm;
  }
  std::vector<std::vector<typename G::Vector>> from(components.count), to(components.count);
  for (const GraphPrior<G>& prior : graph.priors()) {
    const int c = components.of_node[prior.node];
    if (!movable[c] || !MeasuresPosition(prior)) continue;
    from[c].push_back((*poses)[prior.node] * typename G::Vector(prior.offset.translation()));
    to[c].push_back(prior.measurement.translation());
  }
  std::vector<G> motion(components.count);
  for (int c = 0; c < components.count; ++c) {
    if (!from[c].empty()) motion[c] = RigidMotion<G>(from[c], to[c]);
  }
  for (std::size_t i = 0; i < poses->size(); ++i) {
    const int c = components.of_node[i];
    if (!from[c].empty()) (*poses)[i] = (motion[c] * (*poses)[i]).Normalized();
  }
}

template <typename G>
class Guesser {
 public:
  explicit Guesser(const PoseGraph<G>& graph)
      : graph_(graph),
        components_(FindComponents(graph)),
        anchors_(FindAnchors(graph, components_)) {}

  Result<std::vector<G>> Guess(InitMethod method) const {
    if (method == InitMethod::kFile) return FromFile();
    if (method == InitMethod::kOdometry) return Aligned(Compose(OdometryLengths(graph_)));
    std::vector<G> tree = Compose(UncertaintyLengths(graph_));
    if (method == InitMethod::kSpanningTree) return Aligned(std::move(tree));
    Result<std::vector<G>> chordal =
        method == InitMethod::kChordal
            ? ChordalPoses(graph_, anchors_, tree)
            : JointChordalPoses(graph_, anchors_, tree, JointChordalOptions());
    if (!chordal.ok()) return chordal;
    return Aligned(std::move(*chordal));
  }

  Result<std::vector<G>> Another(const std::vector<double>& weights, int turn) const {
    JointChordalOptions options;
    options.weights = weights;
    // Turns that divide the components by the golden ratio are never near one another.
    const double at = std::fmod(turn * 0.6180339887498949, 1);
    std::vector<std::vector<int>> nodes(components_.count);
    for (std::size_t k = 0; k < components_.of_node.size(); ++k) {
      nodes[components_.of_node[k]].push_back(static_cast<int>(k));
    }
    for (const Anchor<G>& anchor : anchors_) {
      const std::vector<int>& all = nodes[components_.of_node[anchor.node]];
      options.roots.push_back(all[static_cast<std::size_t>(at * static_cast<double>(all.size()))]);
    }
    Result<std::vector<G>> poses =
        JointChordalPoses(graph_, anchors_, Compose(UncertaintyLengths(graph_)), options);
    if (!poses.ok()) return poses;
    return Aligned(std::move(*poses));
  }

 private:
  std::vector<G> Compose(const std::vector<double>& lengths) const {
    return ComposeAlongShortestPaths(graph_, anchors_, lengths);
  }

  std::vector<G> Aligned(std::vector<G> poses) const {
    AlignToPriors(graph_, components_, anchors_, &poses);
    return poses;
  }

  std::vector<G> FromFile() const {
    std::vector<bool> has_pose(components_.count, false);
    std::vector<Anchor<G>> known;
    for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
      const GraphNode<G>& node = graph_.nodes()[i];
      if (!node.has_pose) continue;
      has_pose[components_.of_node[i]] = true;
      known.push_back({i, node.pose, true});
    }
    for (const Anchor<G>& anchor : anchors_) {
      if (!has_pose[components_.of_node[anchor.node]]) known.push_back(anchor);
    }
    return ComposeAlongShortestPaths(graph_, known, OdometryLengths(graph_));
  }

  const PoseGraph<G>& graph_;
  const Components components_;
  const std::vector<Anchor<G>> anchors_;
};

template <typename G>
std::vector<InitMethod> MethodsToTry(InitMethod method, const PoseGraph<G>& graph) {
  if (method != InitMethod::kAuto) return {method};
  std::vector<InitMethod> methods;
  const auto has_pose = [](const GraphNode<G>& node) { return node.has_pose; };
  if (std::any_of(graph.nodes().begin(), graph.nodes().end(), has_pose)) {
    methods.push_back(InitMethod::kFile);
  }
  methods.insert(methods.end(), {InitMethod::kOdometry, InitMethod::kSpanningTree,
                                 InitMethod::kChordal, InitMethod::kJointChordal});
  return methods;
}

}  // namespace

const char* InitMethodName(InitMethod method) {
  for (const NamedMethod& entry : kNames) {
    if (entry.method == method) return entry.name;
  }
  return "unknown";
}

std::optional<InitMethod> ParseInitMethod(const std::string& name) {
  for (const NamedMethod& entry : kNames) {
    if (name == entry.name) return entry.method;
  }
  return std::nullopt;
}

template <typename G>
Result<InitialGuess<G>> MakeInitialGuess(InitMethod method, const PoseGraph<G>& graph,
                                         const std::function<double(const std::vector<G>&)>& cost,
                                         const std::atomic<bool>* cancel) {
  using Clock = std::chrono::steady_clock;
  const Guesser<G> guesser(graph);
  InitialGuess<G> guess;
  double best = 0;
  bool found = false;
  for (const InitMethod tried : MethodsToTry(method, graph)) {
    if (cancel != nullptr && *cancel) break;
    const Clock::time_point begin = Clock::now();
    InitCandidate candidate;
    candidate.method = tried;
    Result<std::vector<G>> poses = guesser.Guess(tried);
    candidate.status = poses.status();
    if (poses.ok()) {
      candidate.cost = cost(*poses);
      if (!std::isfinite(candidate.cost)) {
        candidate.status =
            Status(StatusCode::kNoSolution,
                   std::string("init ") + InitMethodName(tried) + ": the cost is not finite");
      } else if (!found || candidate.cost < best * (1 - kTie)) {
        found = true;
        best = candidate.cost;
        guess.method = tried;
        guess.poses = std::move(*poses);
      }
    }
    candidate.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    guess.candidates.push_back(std::move(candidate));
  }
  if (found) return guess;
  if (guess.candidates.empty()) {
    return Status(StatusCode::kInterrupted, "cancelled before there was an initial guess");
  }
  return guess.candidates.front().status;
}

template <typename G>
Result<std::vector<G>> AnotherGuess(const PoseGraph<G>& graph, const std::vector<double>& weights,
                                    int turn) {
  return Guesser<G>(graph).Another(weights, turn);
}

template Result<std::vector<SE2>> AnotherGuess(const PoseGraph<SE2>&, const std::vector<double>&,
                                               int);
template Result<std::vector<SE3>> AnotherGuess(const PoseGraph<SE3>&, const std::vector<double>&,
                                               int);
template Result<std::vector<YawPose>> AnotherGuess(const PoseGraph<YawPose>&,
                                                   const std::vector<double>&, int);
template Result<InitialGuess<SE2>> MakeInitialGuess(
    InitMethod, const PoseGraph<SE2>&, const std::function<double(const std::vector<SE2>&)>&,
    const std::atomic<bool>*);
template Result<InitialGuess<SE3>> MakeInitialGuess(
    InitMethod, const PoseGraph<SE3>&, const std::function<double(const std::vector<SE3>&)>&,
    const std::atomic<bool>*);
template Result<InitialGuess<YawPose>> MakeInitialGuess(
    InitMethod, const PoseGraph<YawPose>&,
    const std::function<double(const std::vector<YawPose>&)>&, const std::atomic<bool>*);

}  // namespace hpgo
