// Random damage to valid files: reading ends with a graph or with an error that names the file, and
// what was read can be written.
#include <random>

#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/trajectory.h"
#include "test/io/graph_text.h"

namespace hpgo {
namespace {

constexpr int kRounds = 4000;

class Damage {
 public:
  explicit Damage(unsigned seed) : random_(seed) {}

  std::string To(std::string text) {
    for (int n = 1 + Below(4); n > 0; --n) Once(&text);
    return text;
  }

 private:
  int Below(std::size_t n) { return static_cast<int>(random_() % n); }

  void Once(std::string* text) {
    static const char* const kPieces[] = {" nan",     " -inf",
                                          "\n",       " ",
                                          " 1e999",   " 0,5",
                                          "FIX 99\n", " 99999999999999999999",
                                          "#",        "\r\n",
                                          " 0",       "-",
                                          "EDGE_SE2", "VERTEX_SE3:QUAT ",
                                          " 1e-320",  "\xEF\xBB\xBF",
                                          " 1e308",   "+",
                                          "EQUIV ",   "\t ",
                                          "VERTEX2 "};
    const std::size_t at = text->empty() ? 0 : static_cast<std::size_t>(Below(text->size()));
    const std::size_t length = static_cast<std::size_t>(Below(30));
    switch (Below(5)) {
      case 0:
        text->erase(at, length);
        break;
      case 1:
        text->insert(at, kPieces[Below(std::size(kPieces))]);
        break;
      case 2:
        if (!text->empty()) (*text)[at] = static_cast<char>(Below(256));
        break;
      case 3:
        text->resize(at);
        break;
      case 4:
        text->insert(static_cast<std::size_t>(Below(text->size() + 1)), text->substr(at, length));
        break;
    }
  }

  std::mt19937 random_;
};

ReadOptions SomeOptions(int round) {
  ReadOptions options;
  options.strict = round % 5 == 0;
  options.project_information = round % 2 == 0;
  options.create_missing = round % 3 == 0;
  options.collect_all_problems = round % 7 == 0;
  return options;
}

class FuzzTest : public ::testing::TestWithParam<const char*> {};

TEST_P(FuzzTest, EndsWithAGraphOrAnError) {
  const std::string valid(
      InputText::Read(std::string(HPGO_TEST_DATA_DIR) + "/" + GetParam())->text());
  Damage damage(1);
  int read = 0, rejected = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::string text = damage.To(valid);
    ReadReport report;
    const Result<AnyGraphFile> file = ReadText(text, SomeOptions(round), &report);
    if (file.ok()) {
      ++read;
      const Status written = WriteG2o(*file, "/dev/null");
      EXPECT_TRUE(written.ok()) << written.message() << "\n" << text;
    } else {
      ++rejected;
      EXPECT_EQ(file.status().code(), StatusCode::kMalformed) << text;
      EXPECT_EQ(file.status().message().substr(0, 2), "f:") << text;
      EXPECT_EQ(report.problems.empty(), round % 7 != 0) << text;
    }
  }
  EXPECT_GT(read, kRounds / 50);
  EXPECT_GT(rejected, kRounds / 50);
}

INSTANTIATE_TEST_SUITE_P(Files, FuzzTest,
                         ::testing::Values("tiny_2d.g2o", "tiny_3d.g2o", "toro_2d.graph",
                                           "toro_3d.graph"));

class TrajectoryFuzzTest : public ::testing::TestWithParam<const char*> {};

TEST_P(TrajectoryFuzzTest, EndsWithATrajectoryOrAnError) {
  const std::string valid(
      InputText::Read(std::string(HPGO_TEST_DATA_DIR) + "/" + GetParam())->text());
  Damage damage(2);
  for (int round = 0; round < kRounds; ++round) {
    const std::string text = damage.To(valid);
    const Result<Trajectory> read =
        ParseTrajectory(text, "f", TrajectoryFormat::kAuto, SomeOptions(round), nullptr);
    if (read.ok()) {
      EXPECT_TRUE(WriteTrajectory(*read, TrajectoryFormat::kTum, "/dev/null").ok()) << text;
    } else {
      EXPECT_EQ(read.status().message().substr(0, 2), "f:") << text;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, TrajectoryFuzzTest, ::testing::Values("kitti.txt", "tum.tum"));

}  // namespace
}  // namespace hpgo
