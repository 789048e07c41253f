// Optimizer: what has changed of the map that a client holds.

#include "hpgo/optimizer_impl.h"
#include "hpgo/update/motion.h"

namespace hpgo {

template <typename G>
void Optimizer<G>::Impl::NoteGivenPose(Index node, const G& pose) {
  if (takes_corrections_) given_[node] = pose.Normalized();
}

// Before a node is removed: the newest of the last taking passes its motion on to one that stays.
template <typename G>
void Optimizer<G>::Impl::ForgetNode(Index node) {
  given_.erase(node);
  if (reference_ != node) return;
  const G motion = graph_.WorldPose(node) * reference_pose_.Inverse();
  reference_ = kNone;
  graph_.ForEachEdgeOf(node, [&](Index, Index other) {
    if (other != kNone) reference_ = other;  // the oldest edge is visited last
  });
  if (reference_ == kNone && newest_ != kNone && newest_ != node) reference_ = newest_;
  if (reference_ != kNone) reference_pose_ = motion.Inverse() * graph_.WorldPose(reference_);
}

template <typename G>
typename Optimizer<G>::Corrections Optimizer<G>::Impl::TakeCorrections(double distance,
                                                                       double angle) {
  Corrections corrections;
  std::unordered_map<Index, G> given;
  given.swap(given_);
  takes_corrections_ = true;
  graph_.ForEachMoved(distance, angle, [&](Index node, const G& pose) {
    const auto it = given.find(node);
    if (it != given.end()) {
      const Motion motion = MotionBetween(it->second, pose);
      if (!(motion.distance > distance || motion.angle > angle)) return;
    }
    corrections.moved.emplace_back(ids_[node], pose);
  });
  if (reference_ != kNone) {
    corrections.motion = (graph_.WorldPose(reference_) * reference_pose_.Inverse()).Normalized();
  }
  if (newest_ != kNone) reference_ = newest_;
  if (reference_ != kNone) reference_pose_ = graph_.WorldPose(reference_);
  return corrections;
}

template <typename G>
typename Optimizer<G>::Corrections Optimizer<G>::TakeCorrections(double distance, double angle) {
  return impl_->TakeCorrections(distance, angle);
}

template class Optimizer<SE2>;
template class Optimizer<SE3>;
template class Optimizer<YawPose>;

}  // namespace hpgo
