#include "hpgo/optimizer.h"

#include <utility>

#include "glog/logging.h"
#include "hpgo/graph/validate.h"
#include "hpgo/optimizer_impl.h"

namespace hpgo {
namespace {

template <typename G>
EdgeData<G> MakeData(const G& measurement, const typename G::Matrix& information,
                     typename Optimizer<G>::Loss loss) {
  EdgeData<G> data;
  data.loss = std::move(loss);
  data.term.measurement = measurement;
  data.term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  return data;
}

}  // namespace

template <typename G>
Optimizer<G>::Optimizer(const OptimizerOptions& options) {
  const Status status = options.Validate();
  CHECK(status.ok()) << status.ToString();
  impl_ = std::make_unique<Impl>(options);
}
template <typename G>
Optimizer<G>::Optimizer(Optimizer&&) noexcept = default;
template <typename G>
Optimizer<G>& Optimizer<G>::operator=(Optimizer&&) noexcept = default;
template <typename G>
Optimizer<G>::~Optimizer() = default;
template <typename G>
const OptimizerOptions& Optimizer<G>::options() const {
  return impl_->options();
}

template <typename G>
Status Optimizer<G>::AddNode(NodeId id, const G& pose) {
  return impl_->AddNode(id, pose);
}
template <typename G>
Result<EdgeId> Optimizer<G>::AddEdge(NodeId i, NodeId j, const G& measurement,
                                     const Matrix& information, Loss loss, InfoFrame frame) {
  const Status status = CheckMeasurement(measurement, information, EdgeName(i, j));
  if (!status.ok()) return status;
  return impl_->AddEdge(
      i, j,
      MakeData(measurement, StoredInformation(frame, measurement, information), std::move(loss)));
}
template <typename G>
Result<EdgeId> Optimizer<G>::AddCustomEdge(NodeId i, NodeId j,
                                           std::shared_ptr<const ceres::CostFunction> cost,
                                           const G& measurement, const Matrix& information,
                                           Loss loss) {
  const std::vector<std::int32_t> blocks(2, G::kParams);
  if (cost == nullptr || cost->parameter_block_sizes() != blocks) {
    return Status(StatusCode::kInvalidArgument,
                  EdgeName(i, j) + ": the cost is not over two poses");
  }
  const Status status = CheckMeasurement(measurement, information, EdgeName(i, j));
  if (!status.ok()) return status;
  EdgeData<G> data = MakeData(measurement, information, std::move(loss));
  data.custom = std::move(cost);
  return impl_->AddEdge(i, j, std::move(data));
}
template <typename G>
Result<EdgeId> Optimizer<G>::AddPrior(NodeId id, const G& measurement, const Matrix& information,
                                      const G& offset, Loss loss) {
  Status status = CheckMeasurement(measurement, information, PriorName(id));
  if (status.ok()) status = CheckPose(offset, PriorName(id) + ": the offset");
  if (!status.ok()) return status;
  EdgeData<G> data = MakeData(measurement, information, std::move(loss));
  data.offset = std::make_shared<G>(offset);
  return impl_->AddPrior(id, std::move(data));
}
template <typename G>
Result<EdgeId> Optimizer<G>::AddCustomPrior(NodeId id,
                                            std::shared_ptr<const ceres::CostFunction> cost,
                                            const G& measurement, const Matrix& information,
                                            Loss loss) {
  const std::vector<std::int32_t> blocks(1, G::kParams);
  if (cost == nullptr || cost->parameter_block_sizes() != blocks) {
    return Status(StatusCode::kInvalidArgument, PriorName(id) + ": the cost is not over one pose");
  }
  const Status status = CheckMeasurement(measurement, information, PriorName(id));
  if (!status.ok()) return status;
  EdgeData<G> data = MakeData(measurement, information, std::move(loss));
  data.custom = std::move(cost);
  data.offset = std::make_shared<G>();
  return impl_->AddPrior(id, std::move(data));
}
template <typename G>
Status Optimizer<G>::RemoveEdge(EdgeId edge) {
  return impl_->RemoveEdge(edge);
}
template <typename G>
Status Optimizer<G>::SetFixed(NodeId id, bool fixed) {
  return impl_->SetFixed(id, fixed);
}
template <typename G>
Status Optimizer<G>::SetPose(NodeId id, const G& pose) {
  return impl_->SetPose(id, pose);
}
template <typename G>
void Optimizer<G>::Clear() {
  impl_ = std::make_unique<Impl>(OptimizerOptions(impl_->options()));
}

template <typename G>
UpdateReport Optimizer<G>::Update(const UpdateLimits& limits) {
  return impl_->Update(impl_->options().mode, limits);
}
template <typename G>
UpdateReport Optimizer<G>::Optimize(Mode mode, const UpdateLimits& limits) {
  return impl_->Update(mode, limits);
}
template <typename G>
UpdateReport Optimizer<G>::Refine(const UpdateLimits& limits) {
  return impl_->Refine(limits);
}

template <typename G>
UpdateReport Optimizer<G>::Converge(const UpdateLimits& limits) {
  return impl_->Converge(limits);
}

template <typename G>
Result<G> Optimizer<G>::GetPose(NodeId id) const {
  return impl_->GetPose(id);
}
template <typename G>
bool Optimizer<G>::HasNode(NodeId id) const {
  return impl_->ids().Find(id) != IdMap::kAbsent;
}
template <typename G>
std::size_t Optimizer<G>::num_nodes() const {
  return impl_->num_nodes();
}
template <typename G>
std::size_t Optimizer<G>::num_edges() const {
  return impl_->num_edges();
}
template <typename G>
void Optimizer<G>::ForEachPose(const std::function<void(NodeId, const G&)>& visit) const {
  impl_->ForEachPose(visit);
}
template <typename G>
void Optimizer<G>::ForEachMoved(double distance, double angle,
                                const std::function<void(NodeId, const G&)>& visit) {
  impl_->ForEachMoved(distance, angle, visit);
}
template <typename G>
Result<typename Optimizer<G>::Group> Optimizer<G>::GetGroup(NodeId id, int level) const {
  return impl_->GetGroup(id, level);
}
template <typename G>
int Optimizer<G>::num_levels() const {
  return impl_->hierarchy().num_levels();
}
template <typename G>
std::vector<EdgeError> Optimizer<G>::EdgeErrors() const {
  return impl_->EdgeErrors();
}
template <typename G>
Result<EdgeError> Optimizer<G>::GetEdgeError(EdgeId edge) const {
  return impl_->GetEdgeError(edge);
}
template <typename G>
double Optimizer<G>::Cost() const {
  return impl_->Cost();
}
template <typename G>
Result<std::shared_ptr<CeresLevel<G>>> Optimizer<G>::LevelProblem(int level) {
  return impl_->LevelProblem(level);
}
template <typename G>
PoseGraph<G> Optimizer<G>::ToGraph() const {
  return impl_->ToGraph();
}
template <typename G>
Status Optimizer<G>::AddGraph(const PoseGraph<G>& graph) {
  return impl_->AddGraph(graph);
}
template <typename G>
std::string Optimizer<G>::FindInconsistency() const {
  return impl_->FindInconsistency();
}
template <typename G>
const Hierarchy<G>& Optimizer<G>::hierarchy() const {
  return impl_->hierarchy();
}
template <typename G>
std::size_t Optimizer<G>::MemoryBytes() const {
  return impl_->MemoryBytes();
}

template class Optimizer<SE2>;
template class Optimizer<SE3>;
template class Optimizer<YawPose>;

}  // namespace hpgo
