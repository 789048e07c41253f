#include "hpgo/io/record_reader.h"

#include <cmath>
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
  identity_ = false;
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
  const int fields_there = CountFields(text_) - 1;
  const bool no_information =
      tag_->information > 0 && fields_there == tag_->ids + tag_->pose && ids_read_ == tag_->ids;
  if (!ok && fields->failed_field().empty() && no_information && options_.identity_information) {
    TakeIdentity();
    return true;
  }
  if (!ok && !fields->failed_field().empty()) {
    Fail(name + ": " + fields->what_failed(), fields->failed_field());
  } else {
    Fail(name + " needs " + std::to_string(tag_->fields()) + " numbers, has " +
             std::to_string(fields_there) +
             (no_information
                  ? ", the information is missing (--identity_information takes the identity)"
                  : ""),
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
void RecordReader<G>::TakeIdentity() {
  identity_ = true;
  double* number = numbers_.data() + tag_->pose;
  for (int row = 0, left = tag_->information; left > 0; ++row) {
    // As many numbers are left as the rows from here on have.
    const int length = (static_cast<int>(std::lround(std::sqrt(8.0 * left + 1))) - 1) / 2;
    *number++ = 1;
    for (int k = 1; k < length; ++k) *number++ = 0;
    left -= length;
  }
  ++counts_->identity_informations;
  log_->Warn(WarningKind::kIdentity, number_, "no information, the identity is taken", text_);
}

template <typename G>
bool RecordReader<G>::TakeInformation(typename G::Matrix* information) {
  const double* numbers = numbers_.data() + tag_->pose;
  const std::size_t bytes = static_cast<std::size_t>(tag_->information) * sizeof(double);
  if (identity_) {
    ToInformation(numbers, *tag_, Edge2Order::kRowMajor, information);
    return true;
  }
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
    Fail(what + IndefiniteHint(), text);
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

template <typename G>
bool RecordReader<G>::IsValidInOrder(Edge2Order order) const {
  typename G::Matrix information;
  ToInformation(numbers_.data() + tag_->pose, *tag_, order, &information);
  const ceres_costs::InformationKind kind = ceres_costs::ClassifyInformation<G::kDof>(information);
  return kind == ceres_costs::InformationKind::kPositiveDefinite ||
         kind == ceres_costs::InformationKind::kSemiDefinite;
}

template <typename G>
std::string RecordReader<G>::IndefiniteHint() const {
  const std::string project = "--project_information takes the nearest that is";
  if (tag_->form != InformationForm::kToro) return " (" + project + ")";
  const bool toro = options_.edge2_order == Edge2Order::kToro;
  const bool other = IsValidInOrder(toro ? Edge2Order::kRowMajor : Edge2Order::kToro);
  if (toro) {
    return " (in TORO's order xx xy yy tt xt yt; " +
           (other ? "--row_major_edge2 reads it row by row" : project) + ")";
  }
  return " (row by row, as --row_major_edge2 says; " +
         (other ? "in TORO's order it would be" : project) + ")";
}

template class RecordReader<SE2>;
template class RecordReader<SE3>;

}  // namespace hpgo
