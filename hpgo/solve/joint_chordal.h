// Initial guess by one linear relaxation of rotations and translations together.
//
// Chordal relaxation (chordal.h) looks at rotations alone. Where they are noisy the translations
// know better: an edge's own tells which way both of its poses look. With the rotations relaxed to
// any d x d matrices R the translations' errors are linear too, and
//   sum over edges of p |R_j - R_i R_ij|_F^2 + w |t_j - t_i - R_i t_ij|^2
// is one system with d + 1 rows a node. With isotropic information that is the objective itself, in
// the convention of 3D g2o files: only det R = 1, R' R = I is missing. Then each R is projected,
// and the translations are found anew for the rotations that came of it. (Rosen et al., SE-Sync,
// IJRR 2019, relaxes the same problem more tightly.)
#pragma once

#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/initial_guess_tree.h"

namespace hpgo {

struct JointChordalOptions {
  // Factors on the edges' information, by edge; empty: all 1.
  std::vector<double> weights;
  // By anchor: the node that is held while the rotations are found, where the anchor is not firm.
  // What the relaxation loses grows with the distance from it. Empty: the anchors themselves.
  std::vector<int> roots;
};

// The guess with the anchors' poses held; every component needs one. `start` gives the rotations
// that the relaxation leaves undefined. kNoSolution if a factorization fails.
template <typename G>
Result<std::vector<G>> JointChordalPoses(const PoseGraph<G>& graph,
                                         const std::vector<Anchor<G>>& anchors,
                                         const std::vector<G>& start,
                                         const JointChordalOptions& options);

}  // namespace hpgo
