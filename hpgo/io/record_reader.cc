#include "hpgo/io/record_reader.h"

#include <cstring>

#include "ceres_costs/whitening.h"
#include "hpgo/graph/validate.h"
#include "hpgo/io/record_fields.h"

namespace hpgo {

template <typename G>
void RecordReader<G>::Begin(std::int64_t number, std::string_view text, const RecordTag* tag) {
  number_ = number;
  text_ = text;
  tag_ = tag;
  ids_read_ = 0;
}

template <typename G>
void RecordReader<G>::Fail(const std::string& what, std::string_view offending) {
  log_->Error(number_, what, offending);
}

template <typename G>
void RecordReader<G>::Oddity(WarningKind kind, const std::string& what,
                             std::string_view offending) {
  log_->Oddity(kind, number_, what, offending);
}

template <typename G>
bool RecordReader<G>::ReadNumbers(LineFields* fields) {
  const int numbers = tag_->pose + tag_->information;
  bool ok = true;
  for (; ok && ids_read_ < tag_->ids; ids_read_ += ok) ok = fields->Read(&ids_[ids_read_]);
  for (int k = 0; ok && k < numbers; ++k) ok = fields->Read(&numbers_[k]);
  if (ok && fields->AtEnd()) return true;
  const std::string name(tag_->name);
  if (!ok && !fields->failed_field().empty()) {
    Fail(name + ": " + fields->what_failed(), fields->failed_field());
  } else {
    Fail(name + " needs " + std::to_string(tag_->fields()) + " numbers, has " +
             std::to_string(CountFields(text_) - 1),
         text_);
  }
  return false;
}

template <typename G>
bool RecordReader<G>::TakePose(G* pose) {
  double norm = 1;
  const QuaternionState state = ToPose(numbers_.data(), tag_->pose, pose, &norm);
  if (state != QuaternionState::kZero && !PoseProblem(*pose).empty()) {
    Fail("pose " + PoseProblem(*pose), FieldSpan(text_, 1 + tag_->ids, tag_->pose));
    return false;
  }
  if (state == QuaternionState::kUnit) return true;
  const std::string_view quaternion = FieldSpan(text_, 1 + tag_->ids + 3, 4);
  if (state == QuaternionState::kZero) {
    Fail("zero quaternion", quaternion);
    return false;
  }
  ++counts_->normalized_quaternions;
  Oddity(WarningKind::kQuaternion, "quaternion of length " + ShortNumber(norm) + " normalized",
         quaternion);
  return true;
}

template <typename G>
bool RecordReader<G>::TakeInformation(typename G::Matrix* information) {
  const double* numbers = numbers_.data() + tag_->pose;
  const std::size_t bytes = static_cast<std::size_t>(tag_->information) * sizeof(double);
  if (last_tag_ == tag_ && std::memcmp(numbers, last_numbers_.data(), bytes) == 0) {
    *information = last_information_;
    return true;
  }
  ToInformation(numbers, *tag_, options_.edge2_order, information);
  // What the line does not speak of is no rank that it lost.
  const bool whole = tag_->information == kInformationNumbers;
  const std::int64_t odd = counts_->semidefinite_informations + counts_->projected_informations;
  if (!(whole ? CheckBlock<G::kDof>(information) : CheckBlock<G::kDim>(information))) return false;
  if (odd == counts_->semidefinite_informations + counts_->projected_informations) {
    std::memcpy(last_numbers_.data(), numbers, bytes);
    last_tag_ = tag_;
    last_information_ = *information;
  }
  return true;
}

// Classifies the leading N x N block, the rest being zero.
template <typename G>
template <int N>
bool RecordReader<G>::CheckBlock(typename G::Matrix* information) {
  using ceres_costs::InformationKind;
  const Eigen::Matrix<double, N, N> block = information->template topLeftCorner<N, N>();
  InformationKind kind = ceres_costs::ClassifyInformation<N>(block);
  if (block.cwiseAbs().maxCoeff() > kLargestValue) kind = InformationKind::kNotFinite;
  if (kind == InformationKind::kPositiveDefinite) return true;
  if (kind == InformationKind::kSemiDefinite) {
    ++counts_->semidefinite_informations;
    return true;
  }
  const std::string_view text = FieldSpan(text_, 1 + tag_->ids + tag_->pose, tag_->information);
  if (kind == InformationKind::kNotFinite) {
    Fail("information is too large", text);
    return false;
  }
  const std::string what = InformationProblem<N>(block);
  if (!options_.project_information) {
    const bool toro = tag_->toro_order && options_.edge2_order == Edge2Order::kToro;
    Fail(what + (toro ? " (in TORO's order xx xy yy tt xt yt)" : ""), text);
    return false;
  }
  const Eigen::Matrix<double, N, N> projected = ceres_costs::ProjectInformation<N>(block);
  if (!projected.allFinite()) {
    Fail("information is too large", text);
    return false;
  }
  information->template topLeftCorner<N, N>() = projected;
  ++counts_->projected_informations;
  log_->Warn(WarningKind::kProjected, number_, what + ", projected", text);
  return true;
}

template class RecordReader<SE2>;
template class RecordReader<SE3>;

}  // namespace hpgo
