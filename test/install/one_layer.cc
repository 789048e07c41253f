// Uses the graph layer alone.
#include <cstdio>

#include "hpgo/graph/components.h"
#include "hpgo/graph/pose_graph.h"

int main() {
  hpgo::PoseGraph2d graph;
  for (const hpgo::NodeId id : {7, 9}) {
    hpgo::GraphNode<hpgo::SE2> node;
    node.id = id;
    if (!graph.AddNode(node).ok()) return 1;
  }
  const int components = hpgo::FindComponents(graph).count;
  std::printf("%d components\n", components);
  return components == 2 ? 0 : 1;
}
