// Bytes as a trajectory of any format, the first one as the reader's options. What was read and
// written reads back: TUM bit for bit, KITTI as the same matrices.
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "hpgo/io/trajectory.h"
#include "test/fuzz/require.h"

namespace hpgo {
namespace {

Trajectory ReadBack(const Trajectory& trajectory, TrajectoryFormat format) {
  std::string written;
  const Status status = FormatTrajectory(trajectory, format, &written);
  Require(status.ok(), status.message());
  const Result<Trajectory> again =
      ParseTrajectory(written, "again", TrajectoryFormat::kAuto, ReadOptions(), nullptr);
  Require(again.ok(), again.status().message() + "\n" + written);
  Require(again->poses.size() == trajectory.poses.size(), "another number of poses");
  return *again;
}

void ReadWriteRead(std::string_view text, std::uint8_t bits) {
  constexpr TrajectoryFormat kFormats[] = {TrajectoryFormat::kAuto, TrajectoryFormat::kG2o,
                                           TrajectoryFormat::kKitti, TrajectoryFormat::kTum};
  ReadOptions options;
  options.strict = bits & 4;
  options.collect_all_problems = bits & 8;
  const Result<Trajectory> read = ParseTrajectory(text, "f", kFormats[bits & 3], options, nullptr);
  if (!read.ok()) {
    Require(read.status().code() == StatusCode::kMalformed, "an error of another kind");
    Require(read.status().message().substr(0, 2) == "f:", read.status().message());
    return;
  }
  const Trajectory tum = ReadBack(*read, TrajectoryFormat::kTum);
  for (std::size_t k = 0; k < read->poses.size(); ++k) {
    Require(read->stamps.empty() || read->stamps[k] == tum.stamps[k], "another stamp");
    Require(
        std::memcmp(read->poses[k].data(), tum.poses[k].data(), SE3::kParams * sizeof(double)) == 0,
        "another pose");
  }
  const Trajectory kitti = ReadBack(*read, TrajectoryFormat::kKitti);
  for (std::size_t k = 0; k < read->poses.size(); ++k) {
    Require(read->poses[k].translation() == kitti.poses[k].translation(), "another position");
    Require((read->poses[k].matrix() - kitti.poses[k].matrix()).norm() < 1e-12, "another rotation");
  }
}

}  // namespace
}  // namespace hpgo

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  hpgo::ReadWriteRead({reinterpret_cast<const char*>(data) + 1, size - 1}, data[0]);
  return 0;
}
