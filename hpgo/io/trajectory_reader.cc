#include <cmath>
#include <utility>

#include "Eigen/Geometry"
#include "Eigen/SVD"
#include "hpgo/graph/validate.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/line_fields.h"
#include "hpgo/io/message_log.h"
#include "hpgo/io/record_fields.h"
#include "hpgo/io/record_tags.h"
#include "hpgo/io/text_format.h"
#include "hpgo/io/trajectory.h"

namespace hpgo {
namespace {

constexpr int kKittiNumbers = 12, kTumNumbers = 8;
// How far a matrix may be from the nearest rotation, by the largest entry: beyond the first it is
// reported, beyond the second it is none.
constexpr double kRotationTolerance = 1e-3, kNoRotation = 0.1;

std::string_view TakeLine(std::string_view* text) {
  const std::size_t end = text->find('\n');
  const std::string_view line = text->substr(0, end);
  text->remove_prefix(end == std::string_view::npos ? text->size() : end + 1);
  return line;
}

// Reads the lines of a KITTI or TUM file into a trajectory.
class PoseListParser {
 public:
  PoseListParser(const std::string& name, const ReadOptions& options, bool kitti)
      : log_(name, options), kitti_(kitti) {}

  Result<Trajectory> Parse(std::string_view text, ReadReport* report) {
    counts_.bytes = static_cast<std::int64_t>(text.size());
    while (!text.empty() && !log_.stopped()) {
      line_ = TakeLine(&text);
      ++counts_.lines;
      if (LineFields(line_).AtEnd()) continue;
      if (ReadNumbers()) kitti_ ? TakeKitti() : TakeTum();
    }
    if (trajectory_.poses.empty() && log_.ok()) log_.Error(0, "holds no pose", {});
    const Status status = log_.Finish(&counts_);
    *report = std::move(counts_);
    if (!status.ok()) return status;
    return std::move(trajectory_);
  }

 private:
  bool ReadNumbers() {
    const int count = kitti_ ? kKittiNumbers : kTumNumbers;
    LineFields fields(line_);
    int k = 0;
    while (k < count && fields.Read(&numbers_[k])) ++k;
    if (k == count && fields.AtEnd()) return true;
    const std::string name = kitti_ ? "KITTI pose" : "TUM pose";
    if (k < count && !fields.failed_field().empty()) {
      Fail(name + ": " + fields.what_failed(), fields.failed_field());
    } else {
      Fail(name + " needs " + std::to_string(count) + " numbers, has " +
               std::to_string(CountFields(line_)),
           line_);
    }
    return false;
  }

  void TakeTum() {
    SE3 pose;
    double norm = 1;
    const QuaternionState state = ToPose(numbers_ + 1, SE3::kParams, &pose, &norm);
    if (state == QuaternionState::kZero) return Fail("zero quaternion", FieldSpan(line_, 4, 4));
    if (state == QuaternionState::kNormalized) {
      ++counts_.normalized_quaternions;
      log_.Oddity(WarningKind::kQuaternion, counts_.lines,
                  "quaternion of length " + ShortNumber(norm) + " normalized",
                  FieldSpan(line_, 4, 4));
    }
    if (Take(pose)) trajectory_.stamps.push_back(numbers_[0]);
  }

  void TakeKitti() {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> m(numbers_);
    const Eigen::Matrix3d given = m.leftCols<3>();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
    const double off = (R - given).cwiseAbs().maxCoeff();
    if (!(off <= kNoRotation) || R.determinant() < 0) return Fail("not a rotation matrix", line_);
    if (off > kRotationTolerance) {
      log_.Oddity(WarningKind::kQuaternion, counts_.lines,
                  "rotation matrix off by " + ShortNumber(off) + " made one", line_);
    }
    Take(SE3(m.col(3), Eigen::Quaterniond(R).normalized()));
  }

  bool Take(const SE3& pose) {
    const std::string problem = PoseProblem(pose);
    if (problem.empty()) {
      trajectory_.poses.push_back(pose);
    } else {
      Fail("pose " + problem, line_);
    }
    return problem.empty();
  }

  void Fail(const std::string& what, std::string_view offending) {
    log_.Error(counts_.lines, what, offending);
  }

  MessageLog log_;
  const bool kitti_;
  ReadReport counts_;
  std::string_view line_;
  double numbers_[kKittiNumbers] = {};
  Trajectory trajectory_;
};

// What a text is that is no trajectory.
std::string DescribeOther(std::string_view text) {
  const std::string what = DescribeText(text);
  return what.empty() ? "neither g2o nor KITTI nor TUM" : what;
}

}  // namespace

TrajectoryFormat DetectFormat(std::string_view text) {
  text = WithoutByteOrderMark(text);
  while (!text.empty()) {
    const std::string_view line = TakeLine(&text);
    LineFields fields(line);
    if (fields.AtEnd()) continue;
    double number = 0;
    if (!fields.Read(&number)) {
      const char first = LineFields(line).Word().front();
      const bool letter = (first >= 'A' && first <= 'Z') || (first >= 'a' && first <= 'z');
      return letter ? TrajectoryFormat::kG2o : TrajectoryFormat::kAuto;
    }
    const int count = CountFields(line);
    if (count == kKittiNumbers) return TrajectoryFormat::kKitti;
    return count == kTumNumbers ? TrajectoryFormat::kTum : TrajectoryFormat::kAuto;
  }
  return TrajectoryFormat::kAuto;
}

Result<Trajectory> ParseTrajectory(std::string_view text, const std::string& name,
                                   TrajectoryFormat format, const ReadOptions& options,
                                   ReadReport* report) {
  ReadReport unused;
  if (report == nullptr) report = &unused;
  text = WithoutByteOrderMark(text);
  if (format == TrajectoryFormat::kAuto) format = DetectFormat(text);
  // Of a graph, the reader of graphs says it.
  const std::string binary = format == TrajectoryFormat::kG2o ? "" : DescribeBinary(text);
  if (!binary.empty()) return Status(StatusCode::kMalformed, name + ": " + binary);
  if (format == TrajectoryFormat::kAuto) {
    return Status(StatusCode::kMalformed, name + ": " + DescribeOther(text));
  }
  if (format != TrajectoryFormat::kG2o) {
    const bool kitti = format == TrajectoryFormat::kKitti;
    return PoseListParser(name, options, kitti).Parse(text, report);
  }
  const Result<AnyGraphFile> file = ParseG2o(text, name, options, report);
  if (!file.ok()) return file.status();
  return std::visit([](const auto& f) { return ToTrajectory(f.graph); }, *file);
}

Result<Trajectory> ReadTrajectory(const std::string& path, TrajectoryFormat format,
                                  const ReadOptions& options, ReadReport* report) {
  const Result<InputText> input = InputText::Read(path);
  if (!input.ok()) return input.status();
  return ParseTrajectory(input->text(), input->name(), format, options, report);
}

}  // namespace hpgo
