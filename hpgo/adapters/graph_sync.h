// An optimizer kept equal to a graph that its client hands over as a whole each time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "hpgo/optimizer.h"

namespace hpgo {

// Between Begin and End everything that there is is named, by a key of the client's. What is new is
// added, what has changed is changed, what is not named any more goes: the optimizer's work is what
// has changed. After an error the graph is incomplete: Clear it. Not synchronized.
template <typename G, typename Key>
class GraphSync {
 public:
  struct Edge {
    NodeId i = 0, j = 0;  // equal: a prior, of T_world_node
    G measurement;        // T_i_j
    typename G::Matrix information = G::Matrix::Identity();
    typename Optimizer<G>::Loss loss;
    InfoFrame frame = InfoFrame::kMeasurement;
  };

  explicit GraphSync(const OptimizerOptions& options = {}) : optimizer_(options) {
    optimizer_.TakeCorrections();  // from here on everything counts
  }

  void Clear() {
    nodes_.clear();
    edges_.clear();
    optimizer_.Clear();
    optimizer_.TakeCorrections();
  }

  void Begin() { ++round_; }

  // `pose` counts where the node is new, and where it is another than the last one given here.
  Status Node(NodeId id, const G& pose, bool fixed) {
    const auto [it, is_new] = nodes_.try_emplace(id);
    NodeRecord& record = it->second;
    Status status;
    if (is_new) {
      status = optimizer_.AddNode(id, pose);
    } else if (!IsSame(record.given, pose)) {
      status = optimizer_.SetPose(id, pose);
    }
    if (status.ok() && record.fixed != fixed) status = optimizer_.SetFixed(id, fixed);
    if (is_new && !status.ok()) {
      nodes_.erase(it);
      return status;
    }
    record.given = pose;
    record.fixed = fixed;
    record.round = round_;
    return status;
  }
  // The client holds this pose of the node from now on.
  void Told(NodeId id, const G& pose) { nodes_.at(id).given = pose; }
  // Null if the node is not there.
  const G* Given(NodeId id) const {
    const auto it = nodes_.find(id);
    return it == nodes_.end() ? nullptr : &it->second.given;
  }

  // Two edges of the same key in one round are an error of the client: kAlreadyExists.
  Status AddEdge(const Key& key, const Edge& edge) {
    const auto [it, is_new] = edges_.try_emplace(key);
    EdgeRecord& record = it->second;
    if (record.round == round_) {
      return Status(StatusCode::kAlreadyExists, "edge " + std::to_string(edge.i) + " -> " +
                                                    std::to_string(edge.j) + " is there twice");
    }
    if (!is_new && IsSame(record.edge, edge)) {
      record.round = round_;
      return Status::Ok();
    }
    if (!is_new) {
      const Status status = optimizer_.RemoveEdge(record.id);
      if (!status.ok()) return status;
    }
    const Result<EdgeId> id =
        edge.i == edge.j
            ? optimizer_.AddPrior(edge.i, edge.measurement, edge.information, G(), edge.loss)
            : optimizer_.AddEdge(edge.i, edge.j, edge.measurement, edge.information, edge.loss,
                                 edge.frame);
    if (!id.ok()) {
      edges_.erase(it);
      return id.status();
    }
    record = {edge, *id, round_};
    return Status::Ok();
  }

  // Edges go before their nodes do.
  Status End() {
    for (auto it = edges_.begin(); it != edges_.end();) {
      if (it->second.round == round_) {
        ++it;
        continue;
      }
      const Status status = optimizer_.RemoveEdge(it->second.id);
      if (!status.ok()) return status;
      it = edges_.erase(it);
    }
    for (auto it = nodes_.begin(); it != nodes_.end();) {
      if (it->second.round == round_) {
        ++it;
        continue;
      }
      const Status status = optimizer_.RemoveNode(it->first).status();
      if (!status.ok()) return status;
      it = nodes_.erase(it);
    }
    return Status::Ok();
  }

  Optimizer<G>& optimizer() { return optimizer_; }
  const Optimizer<G>& optimizer() const { return optimizer_; }

 private:
  struct NodeRecord {
    G given;
    bool fixed = false;
    std::int64_t round = 0;
  };
  struct EdgeRecord {
    Edge edge;
    EdgeId id;
    std::int64_t round = 0;
  };

  static bool IsSame(const G& a, const G& b) {
    return std::equal(a.data(), a.data() + G::kParams, b.data());
  }
  static bool IsSame(const Edge& a, const Edge& b) {
    return a.i == b.i && a.j == b.j && IsSame(a.measurement, b.measurement) &&
           a.information == b.information && a.loss == b.loss && a.frame == b.frame;
  }

  Optimizer<G> optimizer_;
  std::int64_t round_ = 0;
  std::unordered_map<NodeId, NodeRecord> nodes_;
  std::map<Key, EdgeRecord> edges_;
};

}  // namespace hpgo
