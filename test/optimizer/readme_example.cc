// The example of the README, which holds these lines word for word, and a test that it does.

#include <fstream>
#include <sstream>
#include <string>

#include "gtest/gtest.h"

// [README]
#include "hpgo/optimizer.h"

// Drives once around a square of 10 m, a little bent, and sees the start again.
double DriveAround() {
  const hpgo::SE2 straight(10, 0, 1.5), measured_home(0, 0, 0);
  const hpgo::SE2::Matrix information = 100 * hpgo::SE2::Matrix::Identity();
  hpgo::Optimizer2d optimizer;
  (void)optimizer.AddNode(0, hpgo::SE2());
  for (int k = 1; k <= 4; ++k) {  // each call returns a status that names the node or edge
    (void)optimizer.AddNode(k, *optimizer.GetPose(k - 1) * straight);
    (void)optimizer.AddEdge(k - 1, k, straight, information);
    optimizer.Update();  // bounded, however large the map has become
  }
  (void)optimizer.AddEdge(0, 4, measured_home, information);  // the loop closure
  optimizer.Update();
  optimizer.Refine();                                 // while the robot waits: to the optimum
  return optimizer.GetPose(4)->translation().norm();  // 2.1 m before, now 3 mm
}
// [README]

namespace {

TEST(ReadmeExampleTest, ClosesTheLoop) { EXPECT_NEAR(DriveAround(), 0.003, 0.001); }

TEST(ReadmeExampleTest, StandsInTheReadme) {
  const auto read = [](const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  };
  const std::string readme = read(HPGO_TEST_DATA_DIR "/../../README.md");
  if (readme.empty()) GTEST_SKIP() << "no README.md";
  const std::string source = read(HPGO_TEST_DATA_DIR "/../optimizer/readme_example.cc");
  const std::string mark = "// [README]\n";
  const std::size_t begin = source.find(mark) + mark.size();
  const std::string lines = source.substr(begin, source.find(mark, begin) - begin);
  EXPECT_NE(readme.find("```cpp\n" + lines + "```"), std::string::npos);
}

}  // namespace
