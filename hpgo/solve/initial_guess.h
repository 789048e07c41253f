// Where a full solve starts from.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

enum class InitMethod {
  kFile,          // the nodes' poses; those without one are composed from their neighbours'
  kOdometry,      // composed along consecutive edges
  kSpanningTree,  // composed along the paths of least uncertainty
  kChordal,       // linear relaxation of the rotations, then linear translations (chordal.h)
  kJointChordal,  // one linear relaxation of both (joint_chordal.h)
  kAuto,          // the one of these with the lowest cost; the earlier one on ties
};

// "file", "odometry", "spanning_tree", "chordal", "joint_chordal", "auto"; nothing for any other
// name.
const char* InitMethodName(InitMethod method);
std::optional<InitMethod> ParseInitMethod(const std::string& name);

struct InitCandidate {
  InitMethod method = InitMethod::kFile;
  Status status;  // kNoSolution: this method found no guess
  double cost = 0;
  double seconds = 0;  // to make and evaluate it
  // Of those that a full solve ran to the end (full_solve.h).
  bool solved = false;
  double end_cost = 0;
  int iterations = 0;
};

template <typename G>
struct InitialGuess {
  std::vector<G> poses;                   // by node index
  InitMethod method = InitMethod::kFile;  // the one chosen: never kAuto
  std::vector<InitCandidate> candidates;
};

// A guess of every node's pose. Fixed nodes keep theirs (the identity, if a component's fixed nodes
// have none); a component with neither a fixed node nor a prior keeps the pose of its first node in
// id order. A component that only position priors hold is moved onto them rigidly.
// `cost` is what the solve will minimize, at the poses given; a guess at which it is not finite is
// no candidate. kNoSolution if there is no candidate, kInterrupted if `cancel` (may be null) is set
// before there is one; once it is set no further candidates are tried. The values of the graph must
// be finite. Deterministic.
template <typename G>
Result<InitialGuess<G>> MakeInitialGuess(InitMethod method, const PoseGraph<G>& graph,
                                         const std::function<double(const std::vector<G>&)>& cost,
                                         const std::atomic<bool>* cancel);

// Another joint chordal guess, to look for another minimum from: edge k's information counts
// weights[k] times (all alike if empty), and `turn` = 1, 2, ... names the node of each loose
// component that is held while the rotations are found, far from those of other turns.
template <typename G>
Result<std::vector<G>> AnotherGuess(const PoseGraph<G>& graph, const std::vector<double>& weights,
                                    int turn);

}  // namespace hpgo
