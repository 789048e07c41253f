// Stand-ins of Cartographer's types, as the Types of a CartographerProblem.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <tuple>

namespace hpgo {

struct CartoNodeId {
  int trajectory_id, node_index;
  bool operator<(const CartoNodeId& o) const {
    return std::tie(trajectory_id, node_index) < std::tie(o.trajectory_id, o.node_index);
  }
};
struct CartoSubmapId {
  int trajectory_id, submap_index;
  bool operator<(const CartoSubmapId& o) const {
    return std::tie(trajectory_id, submap_index) < std::tie(o.trajectory_id, o.submap_index);
  }
};
inline int& IndexOf(CartoNodeId& id) { return id.node_index; }
inline int& IndexOf(CartoSubmapId& id) { return id.submap_index; }

// As MapById: ids in order, appended to a trajectory; what is trimmed is not given again.
template <typename Id, typename Data>
class MapById {
 public:
  struct Reference {
    Id id;
    const Data& data;
  };
  class ConstIterator {
   public:
    using iterator_category = std::bidirectional_iterator_tag;
    using value_type = Reference;
    using difference_type = std::ptrdiff_t;
    using pointer = const Reference*;
    using reference = Reference;
    explicit ConstIterator(typename std::map<Id, Data>::const_iterator it) : it_(it) {}
    Reference operator*() const { return {it_->first, it_->second}; }
    ConstIterator& operator++() {
      ++it_;
      return *this;
    }
    ConstIterator& operator--() {
      --it_;
      return *this;
    }
    bool operator==(const ConstIterator& o) const { return it_ == o.it_; }
    bool operator!=(const ConstIterator& o) const { return it_ != o.it_; }

   private:
    typename std::map<Id, Data>::const_iterator it_;
  };
  Id Append(int trajectory_id, const Data& data) {
    Id id{trajectory_id, next_[trajectory_id]++};
    data_.emplace(id, data);
    return id;
  }
  void Insert(Id id, const Data& data) {
    next_[id.trajectory_id] = std::max(next_[id.trajectory_id], IndexOf(id) + 1);
    data_.emplace(id, data);
  }
  void Trim(const Id& id) { data_.erase(id); }
  Data& at(const Id& id) { return data_.at(id); }
  const Data& at(const Id& id) const { return data_.at(id); }
  bool empty() const { return data_.empty(); }
  ConstIterator begin() const { return ConstIterator(data_.begin()); }
  ConstIterator end() const { return ConstIterator(data_.end()); }

 private:
  std::map<Id, Data> data_;
  std::map<int, int> next_;
};

template <typename G>
struct StandIns {
  using NodeId = CartoNodeId;
  using SubmapId = CartoSubmapId;
  using Rigid = G;
  struct NodeSpec {
    double time;
    G local, global;
  };
  struct SubmapSpec {
    G global;
  };
  using NodeMap = MapById<NodeId, NodeSpec>;
  using SubmapMap = MapById<SubmapId, SubmapSpec>;
  struct Constraint {
    enum Tag { INTRA_SUBMAP, INTER_SUBMAP };
    struct Pose {
      G zbar_ij;
      double translation_weight, rotation_weight;
    };
    SubmapId submap_id;
    NodeId node_id;
    Pose pose;
    Tag tag;
  };
  enum class TrajectoryState { ACTIVE, FINISHED, FROZEN, DELETED };
  struct ImuData {};
  struct OdometryData {
    double time;
    G pose;
  };
  static const G& Pose(const G& pose) { return pose; }
  static const G& MakeRigid(const G& pose) { return pose; }
  static const G& Measurement(const Constraint& constraint) { return constraint.pose.zbar_ij; }
  static const G& Global(const NodeSpec& node) { return node.global; }
  static void SetGlobal(const G& pose, NodeSpec* node) { node->global = pose; }
  static const G& Global(const SubmapSpec& submap) { return submap.global; }
  static void SetGlobal(const G& pose, SubmapSpec* submap) { submap->global = pose; }
  static SubmapSpec MakeSubmap(const G& pose) { return {pose}; }
  static const G& Local(const NodeSpec& node) { return node.local; }
  static double Time(const NodeSpec& node) { return node.time; }
  static double Time(const OdometryData& data) { return data.time; }
  static const G& Pose(const OdometryData& data) { return data.pose; }
};

}  // namespace hpgo
