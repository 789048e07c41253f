// A fill-reducing order for the Cholesky factorization of a symmetric matrix.
#pragma once

#include <utility>
#include <vector>

namespace hpgo {

struct EliminationOrder {
  std::vector<int> position;  // row -> its place in the order
  std::vector<int> parent;    // of the elimination tree, by place; -1: a root
};

// The order of a matrix of n rows with entries off the diagonal at `pairs` and their transposes:
// distinct, in any order and direction, first != second. By AMD (SuiteSparse), or by METIS where
// the factor is so dense that dissection pays; then in postorder of the elimination tree. Safe to
// call from several threads, which take turns with METIS: it draws from the C library's rand(). So
// deterministic while the program's other threads do not.
EliminationOrder FindEliminationOrder(int n, const std::vector<std::pair<int, int>>& pairs);

}  // namespace hpgo
