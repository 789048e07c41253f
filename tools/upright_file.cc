#include "tools/upright_file.h"

#include <vector>

#include "tools/common_flags.h"

namespace hpgo_cli {

using hpgo::SE3;
using hpgo::YawPose;

std::string DofFlagProblem() {
  if (FLAGS_dof == 0 || FLAGS_dof == 4 || FLAGS_dof == 6) return "";
  return "--dof=" + std::to_string(FLAGS_dof) + ": must be 4 or 6";
}

std::string DofMisfit(int dimension, const std::string& name) {
  if (FLAGS_dof == 0 || dimension == 3) return "";
  return name + ": --dof=" + std::to_string(FLAGS_dof) + " is for 3D graphs";
}

hpgo::Result<hpgo::UprightGraph> MakeUpright(const hpgo::PoseGraph<SE3>& graph,
                                             const std::string& name) {
  hpgo::Result<hpgo::UprightGraph> result = hpgo::MakeUpright(graph, ConventionOfFlag());
  if (result.ok()) return result;
  return hpgo::Status(result.status().code(), name + ": --dof=4: " + result.status().message());
}

hpgo::PoseGraph<SE3> WithUprightPoses(const hpgo::PoseGraph<SE3>& whole,
                                      const hpgo::UprightGraph& upright,
                                      const hpgo::PoseGraph<YawPose>& estimate) {
  hpgo::PoseGraph<SE3> result;
  std::vector<int> place(whole.nodes().size(), -1);
  for (const hpgo::GraphNode<YawPose>& node : estimate.nodes()) {
    const int n = *whole.Find(node.id);
    hpgo::GraphNode<SE3> copy = whole.nodes()[n];
    if (!copy.fixed) copy.pose = upright.Tilted(n, node.pose);
    place[n] = *result.AddNode(copy);
  }
  for (hpgo::GraphEdge<SE3> edge : whole.edges()) {
    edge.i = place[edge.i];
    edge.j = place[edge.j];
    if (edge.i >= 0 && edge.j >= 0) (void)result.AddEdge(edge);
  }
  for (hpgo::GraphPrior<SE3> prior : whole.priors()) {
    prior.node = place[prior.node];
    if (prior.node >= 0) (void)result.AddPrior(prior);
  }
  return result;
}

}  // namespace hpgo_cli
