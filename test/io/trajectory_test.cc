#include "hpgo/io/trajectory.h"

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "gmock/gmock.h"
#include "hpgo/io/input_text.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string Golden(const std::string& name) { return std::string(HPGO_TEST_DATA_DIR) + "/" + name; }

Result<Trajectory> ReadText(const std::string& text,
                            TrajectoryFormat format = TrajectoryFormat::kAuto,
                            ReadReport* report = nullptr) {
  return ParseTrajectory(text, "f", format, ReadOptions(), report);
}

std::string Written(const Trajectory& trajectory, TrajectoryFormat format) {
  const std::string path =
      ::testing::TempDir() + "/hpgo_trajectory_" + std::to_string(getpid()) + ".txt";
  const Status status = WriteTrajectory(trajectory, format, path);
  EXPECT_TRUE(status.ok()) << status.message();
  const Result<InputText> text = InputText::Read(path);
  std::filesystem::remove(path);
  return std::string(text->text());
}

TEST(Trajectory, DetectsTheFormatByContent) {
  EXPECT_EQ(DetectFormat("# x\n\n1 0 0 0 0 1 0 0 0 0 1 0\n"), TrajectoryFormat::kKitti);
  EXPECT_EQ(DetectFormat("\xEF\xBB\xBF 1.5 0 0 0 0 0 0 1\r\n"), TrajectoryFormat::kTum);
  EXPECT_EQ(DetectFormat("VERTEX_SE2 0 0 0 0\n"), TrajectoryFormat::kG2o);
  EXPECT_EQ(DetectFormat("1 2 3\n"), TrajectoryFormat::kAuto);
  EXPECT_EQ(DetectFormat(""), TrajectoryFormat::kAuto);
  EXPECT_EQ(ReadText("1 2 3\n").status().message(),
            "f: looks like a table of 3 numbers a line, no graph and no trajectory");
}

TEST(Trajectory, ReadsKitti) {
  const Result<Trajectory> read =
      ReadTrajectory(Golden("kitti.txt"), TrajectoryFormat::kAuto, ReadOptions(), nullptr);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->poses.size(), 2u);
  EXPECT_THAT(read->stamps, IsEmpty());
  EXPECT_THAT(read->ids, IsEmpty());
  const SE3& pose = read->poses[1];
  EXPECT_EQ(pose.translation(), Eigen::Vector3d(1, 2.5, -3));
  EXPECT_TRUE((pose * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3.5, -3), 1e-15));
}

TEST(Trajectory, ReadsAndWritesTum) {
  const Result<Trajectory> read =
      ReadTrajectory(Golden("tum.tum"), TrajectoryFormat::kAuto, ReadOptions(), nullptr);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_THAT(read->stamps, ElementsAre(1305031102.175304, 1305031102.211214));
  EXPECT_EQ(read->poses[1].rotation().z(), 0.6);
  EXPECT_EQ(Written(*read, TrajectoryFormat::kTum),
            "1305031102.175304 1.5 -2.25 0.125 0 0 0 1\n"
            "1305031102.211214 1.5 -2 0.25 0 0 0.6 0.8\n");
  EXPECT_EQ(Written(*read, TrajectoryFormat::kKitti),
            "1 0 0 1.5 0 1 0 -2.25 0 0 1 0.125\n"
            "0.28 -0.96 0 1.5 0.96 0.28 0 -2 0 0 1 0.25\n");
}

TEST(Trajectory, WithoutStampsTumHasIdsOrNumbers) {
  Trajectory trajectory;
  trajectory.poses.resize(2);
  EXPECT_EQ(Written(trajectory, TrajectoryFormat::kTum), "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n");
  trajectory.ids = {7, 9};
  EXPECT_EQ(Written(trajectory, TrajectoryFormat::kTum), "7 0 0 0 0 0 0 1\n9 0 0 0 0 0 0 1\n");
}

TEST(Trajectory, ReadsVerticesInTheOrderOfTheirIds) {
  const Result<Trajectory> read =
      ReadText("VERTEX_SE2 4 1 2 0\nVERTEX_SE2 1 3 4 3.141592653589793\n");
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(read->ids, ElementsAre(1, 4));
  EXPECT_EQ(read->poses[0].translation(), Eigen::Vector3d(3, 4, 0));
  EXPECT_NEAR(read->poses[0].rotation().z(), 1, 1e-15);
  EXPECT_NEAR(read->poses[0].rotation().w(), 0, 1e-15);
  EXPECT_EQ(read->poses[1].rotation().w(), 1);
}

TEST(Trajectory, ComposesPosesWhereThereAreEdgesOnly) {
  const Result<Trajectory> read =
      ReadText("EDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 0 1 0 1 0 0 1 0 1\n");
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read->poses.size(), 3u);
  EXPECT_EQ(read->poses[2].translation(), Eigen::Vector3d(2, 1, 0));
}

TEST(Trajectory, MalformedLinesAreErrors) {
  EXPECT_EQ(ReadText("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0\n").status().message(),
            "f:2: KITTI pose needs 12 numbers, has 3: '1 0 0'");
  EXPECT_EQ(ReadText("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1 5\n").status().message(),
            "f:2: TUM pose needs 8 numbers, has 9: '1 0 0 0 0 0 0 1 5'");
  EXPECT_EQ(ReadText("0 0 0 nan 0 0 0 1\n").status().message(),
            "f:1: TUM pose: not a finite number: 'nan'");
  EXPECT_EQ(ReadText("0 0 0 1 0 0 0 0\n").status().message(), "f:1: zero quaternion: '0 0 0 0'");
  EXPECT_EQ(ReadText("1 0 0 0 0 1 0 0 0 0 -1 0\n").status().message(),
            "f:1: not a rotation matrix: '1 0 0 0 0 1 0 0 0 0 -1 0'");
  EXPECT_EQ(ReadText("2 0 0 0 0 1 0 0 0 0 1 0\n").status().message(),
            "f:1: not a rotation matrix: '2 0 0 0 0 1 0 0 0 0 1 0'");
  EXPECT_EQ(ReadText("0 1e60 0 0 0 0 0 1\n").status().message(),
            "f:1: pose is too large: '0 1e60 0 0 0 0 0 1'");
  EXPECT_EQ(ReadText("1 0 0 1e60 0 1 0 0 0 0 1 0\n").status().message(),
            "f:1: pose is too large: '1 0 0 1e60 0 1 0 0 0 0 1 0'");
  EXPECT_EQ(ReadText("# none\n", TrajectoryFormat::kTum).status().message(), "f: holds no pose");
  EXPECT_EQ(ReadText("VERTEX_SE2 0 0 0\n").status().code(), StatusCode::kMalformed);
}

TEST(Trajectory, WhatIsSlightlyOffIsReported) {
  ReadReport report;
  ASSERT_TRUE(ReadText("0 0 0 0 0 0 0 2\n", TrajectoryFormat::kAuto, &report).ok());
  EXPECT_THAT(report.warnings, ElementsAre("f:1: quaternion of length 2 normalized: '0 0 0 2'"));
  const Result<Trajectory> read =
      ReadText("1 0 0 0 0 1.01 0 0 0 0 1 0\n", TrajectoryFormat::kAuto, &report);
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(report.warnings, ElementsAre("f:1: rotation matrix off by 0.01 made one: "
                                           "'1 0 0 0 0 1.01 0 0 0 0 1 0'"));
  EXPECT_NEAR(read->poses[0].rotation().norm(), 1, 1e-15);
}

TEST(Trajectory, RejectsWhatCouldNotBeReadAgain) {
  Trajectory trajectory;
  trajectory.poses.resize(2);
  const auto error = [&](TrajectoryFormat format) {
    return WriteTrajectory(trajectory, format, "/dev/null").message();
  };
  EXPECT_EQ(error(TrajectoryFormat::kG2o), "a trajectory is written as KITTI or TUM");
  trajectory.stamps = {1};
  EXPECT_EQ(error(TrajectoryFormat::kTum), "1 stamps for 2 poses");
  trajectory.stamps.clear();
  trajectory.ids = {1, 2, 3};
  EXPECT_EQ(error(TrajectoryFormat::kTum), "3 ids for 2 poses");
  trajectory.ids.clear();
  trajectory.poses[1].data()[2] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error(TrajectoryFormat::kKitti), "pose 1 is not finite");
}

TEST(Trajectory, ReadsThePublicGroundTruth) {
  const std::string path = std::string(HPGO_SHARED_DATA_DIR) + "/kitti/gt/07.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no public data sets here";
  ReadReport report;
  const Result<Trajectory> read =
      ReadTrajectory(path, TrajectoryFormat::kAuto, ReadOptions(), &report);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->poses.size(), 1101u);
  EXPECT_THAT(report.warnings, IsEmpty());
  EXPECT_NEAR(read->poses[1100].rotation().norm(), 1, 1e-14);
}

}  // namespace
}  // namespace hpgo
