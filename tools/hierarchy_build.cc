#include "tools/hierarchy_build.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "hpgo/replay.h"

namespace hpgo_cli {
namespace {

using hpgo::Index;
using hpgo::kNone;
using hpgo::SE2;
using hpgo::SE3;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

template <typename G>
hpgo::EdgeData<G> MakeData(const G& measurement, const typename G::Matrix& information) {
  hpgo::EdgeData<G> data;
  data.term.measurement = measurement;
  data.term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  return data;
}

template <typename G>
void Insert(const hpgo::PoseGraph<G>& graph, const hpgo::ReplayStep& step,
            BuiltHierarchy<G>* built) {
  hpgo::Hierarchy<G>& hierarchy = *built->hierarchy;
  const hpgo::GraphNode<G>& node = graph.nodes()[step.node];
  const Index index = built->index[step.node] = hierarchy.AddNode(node.pose);
  if (node.fixed) hierarchy.SetFixed(index, true);
  for (const int k : step.edges) {
    const hpgo::GraphEdge<G>& edge = graph.edges()[k];
    hpgo::EdgeData<G> data = MakeData(edge.measurement, edge.information);
    data.weight = hpgo::ModularityWeight(data.term);
    hierarchy.AddEdge(built->index[edge.i], built->index[edge.j], data);
  }
  for (const int k : step.priors) {
    const hpgo::GraphPrior<G>& prior = graph.priors()[k];
    hpgo::EdgeData<G> data = MakeData(prior.measurement, prior.information);
    data.offset = std::make_shared<G>(prior.offset);
    hierarchy.AddEdge(kNone, index, data);
  }
  hierarchy.AssignGroups();
}

// Q = sum over groups of S_in / m - (K / 2m)^2, with S_in the weight of the edges inside a group,
// K the weighted degree of its members, m the weight of all edges: eq. 1 with every edge counted
// once.
template <typename G>
double Modularity(const hpgo::Level<G>& level, std::size_t num_parents) {
  double inside = 0, total = 0;
  std::vector<double> degree(num_parents, 0);
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    const auto& edge = level.edges[e];
    if (!edge.alive || edge.node[0] == kNone) continue;
    const Index parents[2] = {level.nodes[edge.node[0]].parent, level.nodes[edge.node[1]].parent};
    total += edge.weight;
    if (parents[0] == parents[1]) inside += edge.weight;
    for (const Index parent : parents) degree[parent] += edge.weight;
  }
  if (!(total > 0)) return 0;
  double modularity = inside / total;
  for (const double k : degree) modularity -= k * k / (4 * total * total);
  return modularity;
}

}  // namespace

template <typename G>
BuiltHierarchy<G> BuildIncrementally(const hpgo::PoseGraph<G>& graph,
                                     const hpgo::HierarchyOptions& options) {
  BuiltHierarchy<G> built;
  built.hierarchy = std::make_unique<hpgo::Hierarchy<G>>(options);
  built.index.assign(graph.nodes().size(), kNone);
  built.insert_us.reserve(graph.nodes().size());
  for (const hpgo::ReplayStep& step : hpgo::ReplaySteps(graph)) {
    const Clock::time_point begin = Clock::now();
    Insert(graph, step, &built);
    built.insert_us.push_back(static_cast<float>(1e6 * SecondsSince(begin)));
  }
  const Clock::time_point begin = Clock::now();
  for (int l = 1; l < built.hierarchy->num_levels(); ++l) {
    const hpgo::Level<G>& level = built.hierarchy->level(l);
    for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
      if (!level.edges[e].alive) continue;
      built.hierarchy->Merge(l, e);
      ++built.coarse_edges;
    }
  }
  built.coarse_seconds = SecondsSince(begin);
  return built;
}

template <typename G>
std::vector<LevelFigures> FiguresOf(const hpgo::Hierarchy<G>& hierarchy) {
  std::vector<LevelFigures> figures;
  for (int l = 0; l < hierarchy.num_levels(); ++l) {
    const hpgo::Level<G>& level = hierarchy.level(l);
    LevelFigures f;
    f.nodes = level.num_nodes;
    f.edges = level.num_edges;
    if (l > 0) {
      const auto count = static_cast<double>(std::max<std::int64_t>(1, f.nodes));
      f.fraction = static_cast<double>(f.nodes) / static_cast<double>(figures[0].nodes);
      f.reduction = static_cast<double>(figures.back().nodes) / count;
    }
    if (l + 1 < hierarchy.num_levels()) {
      const hpgo::Level<G>& above = hierarchy.level(l + 1);
      for (Index g = 0; g < static_cast<Index>(above.nodes.size()); ++g) {
        if (!above.nodes[g].alive) continue;
        const auto size = static_cast<std::size_t>(above.nodes[g].num_children);
        if (f.group_sizes.size() < size) f.group_sizes.resize(size, 0);
        ++f.group_sizes[size - 1];
      }
      f.modularity = Modularity(level, above.nodes.size());
    }
    figures.push_back(f);
  }
  return figures;
}

template <typename G>
std::vector<hpgo::PlotHierarchyLevel> PlotLevels(const BuiltHierarchy<G>& built) {
  const hpgo::Hierarchy<G>& hierarchy = *built.hierarchy;
  std::vector<hpgo::PlotHierarchyLevel> levels;
  for (int l = 1; l < hierarchy.num_levels(); ++l) {
    const hpgo::Level<G>& level = hierarchy.level(l);
    hpgo::PlotHierarchyLevel plot;
    plot.level = l;
    std::vector<int> number(level.nodes.size(), -1);  // of the alive ones
    for (std::size_t g = 0; g < number.size(); ++g) {
      if (level.nodes[g].alive) number[g] = plot.num_groups++;
    }
    for (const Index index : built.index) {
      plot.group.push_back(number[hierarchy.Ancestor(index, l)]);
    }
    for (std::size_t e = 0; e < level.edges.size(); ++e) {
      const auto& edge = level.edges[e];
      if (!edge.alive || edge.node[0] == kNone) continue;
      plot.edges.emplace_back(number[edge.node[0]], number[edge.node[1]]);
    }
    levels.push_back(std::move(plot));
  }
  return levels;
}

template BuiltHierarchy<SE2> BuildIncrementally(const hpgo::PoseGraph<SE2>&,
                                                const hpgo::HierarchyOptions&);
template BuiltHierarchy<SE3> BuildIncrementally(const hpgo::PoseGraph<SE3>&,
                                                const hpgo::HierarchyOptions&);
template std::vector<LevelFigures> FiguresOf(const hpgo::Hierarchy<SE2>&);
template std::vector<LevelFigures> FiguresOf(const hpgo::Hierarchy<SE3>&);
template std::vector<hpgo::PlotHierarchyLevel> PlotLevels(const BuiltHierarchy<SE2>&);
template std::vector<hpgo::PlotHierarchyLevel> PlotLevels(const BuiltHierarchy<SE3>&);

}  // namespace hpgo_cli
