#include <vector>

#include "Eigen/Cholesky"
#include "hpgo/hierarchy/coarse_edge.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {
namespace {

using ceres_costs::QuadraticModel;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// The two groups' members, in the frame of the first group, with every edge between two of them.
template <typename G>
struct LocalGraph {
  struct Edge {
    int i, j;
    ceres_costs::FactorTerm<G> factor;
  };
  std::vector<Index> nodes;
  std::vector<G> poses;
  std::vector<Edge> edges;
};

// Appends a group's members; returns the position of its representative, its oldest member.
template <typename G>
int AddMembers(const Hierarchy<G>& hierarchy, int l, Index group, const G& T_frame_group,
               LocalGraph<G>* graph) {
  const Level<G>& below = hierarchy.level(l - 1);
  for (Index c = hierarchy.level(l).nodes[group].first_child; c != kNone;
       c = below.nodes[c].next_sibling) {
    graph->nodes.push_back(c);
    graph->poses.push_back(T_frame_group * below.nodes[c].pose);
  }
  return static_cast<int>(graph->nodes.size()) - 1;
}

template <typename G>
void AddEdges(const Hierarchy<G>& hierarchy, int l, LocalGraph<G>* graph) {
  const Level<G>& below = hierarchy.level(l - 1);
  for (int i = 0; i < static_cast<int>(graph->nodes.size()); ++i) {
    ForEachEdge(below, graph->nodes[i], [&](Index e, Index) {
      if (below.edges[e].node[0] != graph->nodes[i]) return;
      for (int j = 0; j < static_cast<int>(graph->nodes.size()); ++j) {
        if (graph->nodes[j] == below.edges[e].node[1]) {
          graph->edges.push_back({i, j, hierarchy.FactorOf(l - 1, e)});
        }
      }
    });
  }
}

// Composes the poses along the edges from the node `held` on, so that the optimum does not depend
// on how well the estimate fits. A custom cost's measurement approximates it.
template <typename G>
void ComposeFrom(int held, LocalGraph<G>* graph) {
  std::vector<G> poses = graph->poses;
  std::vector<bool> known(poses.size(), false);
  known[held] = true;
  std::size_t missing = poses.size() - 1;
  for (bool found = true; found && missing > 0;) {
    found = false;
    for (const auto& edge : graph->edges) {
      if (known[edge.i] == known[edge.j]) continue;
      const G& Z = edge.factor.term->measurement;
      if (known[edge.i]) {
        poses[edge.j] = poses[edge.i] * Z;
      } else {
        poses[edge.i] = poses[edge.j] * Z.Inverse();
      }
      known[edge.i] = known[edge.j] = found = true;
      --missing;
    }
  }
  if (missing == 0) graph->poses = poses;
}

// One Gauss-Newton system of the local graph with the node `held` constant.
template <typename G>
bool Linearize(const LocalGraph<G>& graph, int held, Eigen::MatrixXd* H, Eigen::VectorXd* g) {
  constexpr int D = G::kDof;
  const int n = static_cast<int>(graph.poses.size()) - 1;
  H->setZero(n * D, n * D);
  g->setZero(n * D);
  const auto position = [held](int k) { return k < held ? k : k - 1; };
  for (const auto& edge : graph.edges) {
    const G Y = graph.poses[edge.i].Between(graph.poses[edge.j]);
    QuadraticModel<G> at_j, at_i;
    if (!LinearizeFactor(edge.factor, false, Y, &at_j)) return false;
    TransportModel(Y.Inverse(), at_j, &at_i);  // J_i = -J_j Ad(Y^-1)
    const int i = position(edge.i) * D, j = position(edge.j) * D;
    if (edge.j != held) {
      H->template block<D, D>(j, j) += at_j.A;
      g->template segment<D>(j) += at_j.b;
    }
    if (edge.i != held) {
      H->template block<D, D>(i, i) += at_i.A;
      g->template segment<D>(i) -= at_i.b;
    }
    if (edge.i != held && edge.j != held) {
      const typename G::Matrix cross = at_j.A * Y.Inverse().Adjoint();
      H->template block<D, D>(j, i) -= cross;
      H->template block<D, D>(i, j) -= cross.transpose();
    }
  }
  return H->allFinite();
}

}  // namespace

template <typename G>
CoarseEdge<G> CondensedEdge(const Hierarchy<G>& hierarchy, int l, Index edge) {
  constexpr int D = G::kDof;
  constexpr int kIterations = 3;
  const LevelEdge& record = hierarchy.level(l).edges[edge];
  // A prior belongs to one group only: there is nothing to condense.
  if (record.node[0] == kNone) return GalerkinEdge(hierarchy, l, edge);
  const G T_g_h = hierarchy.RelativePose(l, record.node[0], record.node[1]);
  LocalGraph<G> graph;
  const int held = AddMembers(hierarchy, l, record.node[0], G(), &graph);
  const int other = AddMembers(hierarchy, l, record.node[1], T_g_h, &graph);
  AddEdges(hierarchy, l, &graph);
  const G X_held = graph.poses[held];
  const G X_other = T_g_h.Between(graph.poses[other]);  // in the second group's frame

  ComposeFrom(held, &graph);

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  Eigen::LDLT<Eigen::MatrixXd> ldlt;
  for (int iteration = 0;; ++iteration) {
    if (!Linearize(graph, held, &H, &g)) return GalerkinEdge(hierarchy, l, edge);
    ldlt.compute(H);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive() ||
        ldlt.vectorD().minCoeff() <= 1e-12 * ldlt.vectorD().maxCoeff()) {
      return GalerkinEdge(hierarchy, l, edge);
    }
    if (iteration == kIterations) break;
    const Eigen::VectorXd step = ldlt.solve(-g);
    for (int k = 0; k < static_cast<int>(graph.poses.size()); ++k) {
      if (k == held) continue;
      const typename G::Tangent d = step.template segment<D>((k < held ? k : k - 1) * D);
      graph.poses[k] = graph.poses[k].Plus(d);
    }
  }
  const int at = (other - 1) * D;  // `other` comes after `held`
  Eigen::MatrixXd selector = Eigen::MatrixXd::Zero(H.rows(), D);
  selector.template middleRows<D>(at).setIdentity();
  const typename G::Matrix covariance = ldlt.solve(selector).template middleRows<D>(at);
  QuadraticModel<G> marginal, at_frame;
  marginal.A = covariance.inverse();
  marginal.A = (0.5 * (marginal.A + marginal.A.transpose())).eval();
  TransportModel(X_other.Inverse(), marginal, &at_frame);

  CoarseEdge<G> result;
  result.T_g_h = T_g_h;
  // X_held is in the frame of the first group, which is the local graph's.
  const G Z = X_held * graph.poses[held].Between(graph.poses[other]) * X_other.Inverse();
  result.term =
      TermFromModel(at_frame, SemiDefiniteInverse<G>(at_frame.A), record.centred ? T_g_h : Z);
  ceres_costs::FactorTerm<G> factor;
  factor.term = &result.term;
  factor.convention = kCoarseConvention;
  LinearizeFactor(factor, false, T_g_h, &result.model);
  result.inverse = SemiDefiniteInverse<G>(result.model.A);
  return result;
}

template CoarseEdge<SE2> CondensedEdge(const Hierarchy<SE2>&, int, Index);
template CoarseEdge<SE3> CondensedEdge(const Hierarchy<SE3>&, int, Index);
template CoarseEdge<YawPose> CondensedEdge(const Hierarchy<YawPose>&, int, Index);

}  // namespace hpgo
