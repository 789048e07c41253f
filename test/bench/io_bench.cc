// How fast graph files are read and written, in bytes of text a second, on one core. The texts look
// like public files: six decimals, an odometry chain and random closures, a different information
// matrix at every edge.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "benchmark/benchmark.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/output_file.h"

namespace hpgo {
namespace {

class TextMaker {
 public:
  // Half as many vertices as edges.
  std::string Planar(int edges) {
    const int nodes = edges / 2;
    for (int k = 0; k < nodes; ++k) {
      Line("VERTEX_SE2 %d", k);
      Numbers(3);
      text_ += '\n';
    }
    for (int k = 0; k < edges; ++k) {
      Ends("EDGE_SE2 %d %d", k, nodes);
      Numbers(3);
      Information(3);
    }
    return std::move(text_);
  }

  std::string Spatial(int edges) {
    const int nodes = edges / 2;
    for (int k = 0; k < nodes; ++k) {
      Line("VERTEX_SE3:QUAT %d", k);
      Pose();
      text_ += '\n';
    }
    for (int k = 0; k < edges; ++k) {
      Ends("EDGE_SE3:QUAT %d %d", k, nodes);
      Pose();
      Information(6);
    }
    return std::move(text_);
  }

 private:
  template <typename... Args>
  void Line(const char* format, Args... args) {
    char buffer[64];
    text_.append(buffer, std::snprintf(buffer, sizeof(buffer), format, args...));
  }
  void Number(double value) { Line(" %.6f", value); }
  void Numbers(int count) {
    for (int k = 0; k < count; ++k) Number(10 * normal_(random_));
  }
  void Ends(const char* format, int k, int nodes) {
    const int i = k < nodes - 1 ? k : static_cast<int>(random_() % nodes);
    const int j =
        k < nodes - 1 ? k + 1 : (i + 1 + static_cast<int>(random_() % (nodes - 1))) % nodes;
    Line(format, i, j);
  }
  void Pose() {
    Numbers(3);
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k) q(k) = normal_(random_);
    q.normalize();
    for (int k = 0; k < 4; ++k) Number(q(k));
  }
  // Diagonally dominant.
  void Information(int size) {
    for (int r = 0; r < size; ++r) {
      for (int c = r; c < size; ++c) Number(r == c ? 500 + normal_(random_) : normal_(random_));
    }
    text_ += '\n';
  }

  std::string text_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

template <typename G>
const std::string& Text(int edges) {
  static std::map<int, std::string>* texts = new std::map<int, std::string>;
  std::string& text = (*texts)[edges];
  if (text.empty()) text = G::kDim == 2 ? TextMaker().Planar(edges) : TextMaker().Spatial(edges);
  return text;
}

std::string TemporaryPath() {
  return (std::filesystem::temp_directory_path() / ("hpgo_io_bench_" + std::to_string(getpid())))
      .string();
}

void Count(benchmark::State& state, std::size_t bytes) {
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
  state.counters["edges"] = static_cast<double>(state.range(0));
}

template <typename G>
void BM_Parse(benchmark::State& state) {
  const std::string& text = Text<G>(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const Result<AnyGraphFile> file = ParseG2o(text, "memory", ReadOptions(), nullptr);
    if (!file.ok()) state.SkipWithError(file.status().message().c_str());
  }
  Count(state, text.size());
}

template <typename G>
void BM_ReadFile(benchmark::State& state) {
  const std::string& text = Text<G>(static_cast<int>(state.range(0)));
  const std::string path = TemporaryPath();
  if (!WriteTextFile(path, text).ok()) state.SkipWithError("no temporary file");
  for (auto _ : state) {
    const Result<AnyGraphFile> file = ReadG2o(path, ReadOptions(), nullptr);
    if (!file.ok()) state.SkipWithError(file.status().message().c_str());
  }
  std::filesystem::remove(path);
  Count(state, text.size());
}

template <typename G>
void BM_WriteFile(benchmark::State& state) {
  const Result<AnyGraphFile> file =
      ParseG2o(Text<G>(static_cast<int>(state.range(0))), "memory", ReadOptions(), nullptr);
  const std::string path = TemporaryPath();
  for (auto _ : state) {
    if (!file.ok() || !WriteG2o(*file, path).ok()) state.SkipWithError("cannot write");
  }
  std::error_code error;
  const std::size_t bytes = std::filesystem::file_size(path, error);
  std::filesystem::remove(path, error);
  Count(state, bytes);
}

constexpr int kSmall = 10000, kLarge = 1000000;
BENCHMARK_TEMPLATE(BM_Parse, SE2)->Arg(kSmall)->Arg(kLarge)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(BM_Parse, SE3)->Arg(kSmall)->Arg(kLarge)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(BM_ReadFile, SE2)->Arg(kLarge)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(BM_ReadFile, SE3)->Arg(kLarge)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(BM_WriteFile, SE2)->Arg(kLarge)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(BM_WriteFile, SE3)->Arg(kLarge)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hpgo
