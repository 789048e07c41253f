#include "hpgo/state/state_reader.h"

#include "ceres_costs/losses.h"

namespace hpgo {

StateReader::StateReader(Source source, const StateObjects* objects)
    : source_(std::move(source)), objects_(objects) {}

void StateReader::Fail(StatusCode code, const std::string& message) {
  if (status_.ok()) status_ = Status(code, message);
  bytes_ = {};
}

StateReader::Block StateReader::Next() {
  if (!ok()) return {};
  const Result<Block> block = source_();
  if (block.ok()) return *block;
  Fail(block.status().code(), block.status().message());
  return {};
}

bool StateReader::Refill(std::size_t width) {
  const Block block = Next();
  if (block.section == section_ && bytes_.empty() && block.bytes.size() >= width) {
    bytes_ = block.bytes;
    return ok();
  }
  Fail(StatusCode::kMalformed, "the section '" + section_ + "' ends too early");
  return false;
}

void StateReader::Section(std::string_view name) {
  if (!bytes_.empty()) {
    Fail(StatusCode::kMalformed, "the section '" + section_ + "' holds more than is known");
  }
  const Block block = Next();
  if (block.section != name) {
    Fail(StatusCode::kMalformed,
         "there is no section '" + std::string(name) + "' where it belongs");
    return;
  }
  section_ = block.section;
  bytes_ = block.bytes;
}

Status StateReader::Finish() {
  if (ok()) Section("");
  return status_;
}

void StateReader::GetLoss(std::shared_ptr<const ceres::LossFunction>* loss) {
  const auto number = GetNumber<std::uint32_t>();
  loss->reset();
  if (number == 0) return;
  if (number <= losses_.size()) {
    *loss = losses_[number - 1];
    return;
  }
  if (number != losses_.size() + 1) {
    Fail(StatusCode::kMalformed, "the section '" + section_ + "' skips a loss");
  } else if (objects_ != nullptr) {
    *loss = objects_->losses[number - 1];
  } else {
    ceres_costs::LossName name;
    (*this)(name.name, name.scale);
    std::unique_ptr<ceres::LossFunction> made;
    std::string error;
    if (ok() && !ceres_costs::MakeLoss(name.name, name.scale, &made, &error)) {
      Fail(StatusCode::kInvalidArgument, error);
    }
    *loss = std::move(made);
  }
  losses_.push_back(*loss);
}

void StateReader::GetCost(std::shared_ptr<const ceres::CostFunction>* cost) {
  cost->reset();
  if (GetNumber<std::uint8_t>() == 0) return;
  if (objects_ != nullptr) {
    *cost = objects_->costs[num_costs_++];
  } else {
    Fail(StatusCode::kMalformed, "the section '" + section_ + "' has a cost without a name");
  }
}

}  // namespace hpgo
