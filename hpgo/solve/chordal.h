// Chordal initial guess: two linear least-squares problems instead of one that is not convex.
//
// Rotations first, relaxed to any d x d matrices: the sum over edges of p |R_j - R_i R_ij|_F^2,
// then each R projected to SO(d). With R_j = R_i R_ij Exp(phi) a summand is 2 p |phi|^2 +
// O(|phi|^4), so that p is half the rotational information. Translations second, with the rotations
// held: exactly the objective, which is then quadratic. (Martinec and Pajdla, CVPR 2007; Carlone et
// al., ICRA 2015.)
#pragma once

#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/initial_guess_tree.h"

namespace hpgo {

// The chordal guess with the anchors' poses held; every component needs one. `start` gives the
// rotations that the relaxation leaves undefined. kNoSolution if a factorization fails.
template <typename G>
Result<std::vector<G>> ChordalPoses(const PoseGraph<G>& graph,
                                    const std::vector<Anchor<G>>& anchors,
                                    const std::vector<G>& start);

// The rotations of `poses` with the translations that the objective asks of them: the second half.
template <typename G>
Result<std::vector<G>> ChordalTranslations(const PoseGraph<G>& graph,
                                           const std::vector<Anchor<G>>& anchors,
                                           const std::vector<G>& poses);

}  // namespace hpgo
