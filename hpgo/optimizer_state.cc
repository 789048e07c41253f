// Optimizer: all there is, saved, loaded and copied.

#include <deque>

#include "ceres_costs/losses.h"
#include "glog/logging.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/state/state_reader.h"
#include "hpgo/state/state_writer.h"

namespace hpgo {

template <typename G>
Status Optimizer<G>::Impl::CheckHasNames() const {
  for (Index edge = 0; edge < graph_.end_of_edges(); ++edge) {
    if (!graph_.IsEdge(edge)) continue;
    const ceres_costs::FactorTerm<G> factor = graph_.FactorOf(edge);
    if (factor.custom != nullptr) {
      return Status(StatusCode::kInvalidArgument,
                    NameOf(edge) + ": its cost is the caller's own, which cannot be saved");
    }
    if (factor.loss != nullptr && !ceres_costs::NameOfLoss(*factor.loss).has_value()) {
      return Status(StatusCode::kInvalidArgument,
                    NameOf(edge) +
                        ": its loss has no name, and cannot be saved; ceres_costs::MakeLoss makes "
                        "losses with one");
    }
  }
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Save(StateWriter* writer) const {
  if (!writer->shares_objects()) {
    const Status status = impl_->CheckHasNames();
    if (!status.ok()) return status;
  }
  writer->Section("options");
  (*writer)(impl_->options());
  const Impl& impl = *impl_;
  Impl::Fields(*writer, impl);
  return writer->Finish();
}

template <typename G>
Status Optimizer<G>::Load(StateReader* reader) {
  OptimizerOptions options;
  reader->Section("options");
  (*reader)(options);
  if (!reader->ok()) return reader->Finish();
  const Status status = options.Validate();
  if (!status.ok()) return status;
  auto impl = std::make_unique<Impl>(options);
  Impl::Fields(*reader, *impl);
  const Status finished = reader->Finish();
  if (finished.ok()) impl_ = std::move(impl);
  return finished;
}

template <typename G>
Optimizer<G> Optimizer<G>::Clone() const {
  StateObjects objects;
  std::deque<std::pair<std::string, std::string>> blocks;
  StateWriter writer(
      [&](const char* section, std::string_view bytes) { blocks.emplace_back(section, bytes); },
      &objects);
  Status status = Save(&writer);
  // A block is given up when the next is asked for.
  bool begun = false;
  StateReader reader(
      [&]() -> Result<StateReader::Block> {
        if (begun) blocks.pop_front();
        begun = true;
        if (blocks.empty()) return StateReader::Block();
        return StateReader::Block{blocks.front().first, blocks.front().second};
      },
      &objects);
  Optimizer copy;
  if (status.ok()) status = copy.Load(&reader);
  CHECK(status.ok()) << status.ToString();
  return copy;
}

template class Optimizer<SE2>;
template class Optimizer<SE3>;
template class Optimizer<YawPose>;

}  // namespace hpgo
