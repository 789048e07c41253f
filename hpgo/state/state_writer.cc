#include "hpgo/state/state_writer.h"

#include <optional>

#include "ceres_costs/losses.h"

namespace hpgo {

StateWriter::StateWriter(Sink sink, StateObjects* objects)
    : sink_(std::move(sink)), objects_(objects), buffer_(new char[kBlockBytes]) {}

void StateWriter::Flush() {
  if (section_ != nullptr) sink_(section_, std::string_view(buffer_.get(), size_));
  size_ = 0;
}

void StateWriter::Section(const char* name) {
  Flush();
  section_ = name;
}

Status StateWriter::Finish() {
  Flush();
  section_ = nullptr;
  return status_;
}

void StateWriter::PutLoss(const std::shared_ptr<const ceres::LossFunction>& loss) {
  if (loss == nullptr) return Put(std::uint32_t{0});
  const auto [it, is_new] =
      losses_.emplace(loss.get(), static_cast<std::uint32_t>(losses_.size() + 1));
  Put(it->second);
  if (!is_new) return;
  if (objects_ != nullptr) {
    objects_->losses.push_back(loss);
    return;
  }
  const std::optional<ceres_costs::LossName> name = ceres_costs::NameOfLoss(*loss);
  if (name.has_value()) {
    (*this)(name->name, name->scale);
  } else if (status_.ok()) {
    status_ = Status(StatusCode::kInvalidArgument, "a loss without a name");
  }
}

void StateWriter::PutCost(const std::shared_ptr<const ceres::CostFunction>& cost) {
  Put(cost != nullptr);
  if (cost == nullptr) return;
  if (objects_ != nullptr) {
    objects_->costs.push_back(cost);
  } else if (status_.ok()) {
    status_ = Status(StatusCode::kInvalidArgument, "a cost of the caller's own");
  }
}

}  // namespace hpgo
