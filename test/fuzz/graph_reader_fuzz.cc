// Bytes as a g2o or TORO file, the first one as the reader's options. What was read and written
// reads back equal, from its own text and without leave; an error names the file.
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>

#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/g2o_writer.h"
#include "test/fuzz/require.h"

namespace hpgo {
namespace {

ReadOptions OptionsOf(std::uint8_t bits) {
  ReadOptions options;
  options.strict = bits & 1;
  options.project_information = bits & 2;
  options.create_missing = bits & 4;
  options.collect_all_problems = bits & 8;
  options.identity_information = bits & 16;
  options.edge2_order = bits & 32 ? Edge2Order::kRowMajor : Edge2Order::kToro;
  return options;
}

template <typename M>
bool SameBits(const M& a, const M& b, int count) {
  return std::memcmp(a.data(), b.data(), static_cast<std::size_t>(count) * sizeof(double)) == 0;
}

template <typename G>
bool SameMeasurement(const G& a, const typename G::Matrix& A, const G& b,
                     const typename G::Matrix& B) {
  return SameBits(a, b, G::kParams) && SameBits(A, B, G::kDof * G::kDof);
}

// Nodes by id: those without a line of their own are written ahead of the others.
template <typename G>
void RequireSame(const GraphFile<G>& a, const GraphFile<G>& b) {
  const PoseGraph<G>&g = a.graph, &h = b.graph;
  Require(g.nodes().size() == h.nodes().size(), "another number of nodes");
  for (const GraphNode<G>& node : g.nodes()) {
    const auto found = h.Find(node.id);
    Require(found.has_value(), "a node is lost");
    const GraphNode<G>& other = h.nodes()[*found];
    Require(node.has_pose == other.has_pose && node.fixed == other.fixed, "another kind of node");
    Require(!node.has_pose || SameBits(node.pose, other.pose, G::kParams), "another pose");
  }
  const auto id = [](const PoseGraph<G>& graph, int node) { return graph.nodes()[node].id; };
  Require(g.edges().size() == h.edges().size(), "another number of edges");
  for (std::size_t k = 0; k < g.edges().size(); ++k) {
    const GraphEdge<G>&e = g.edges()[k], &f = h.edges()[k];
    Require(id(g, e.i) == id(h, f.i) && id(g, e.j) == id(h, f.j), "an edge elsewhere");
    Require(SameMeasurement<G>(e.measurement, e.information, f.measurement, f.information),
            "another measurement");
  }
  Require(g.priors().size() == h.priors().size(), "another number of priors");
  for (std::size_t k = 0; k < g.priors().size(); ++k) {
    const GraphPrior<G>&p = g.priors()[k], &q = h.priors()[k];
    Require(id(g, p.node) == id(h, q.node), "a prior elsewhere");
    Require(SameMeasurement<G>(p.measurement, p.information, q.measurement, q.information) &&
                SameBits(p.offset, q.offset, G::kParams),
            "another prior");
  }
  Require(a.fix == b.fix, "other FIX lines");
  Require(a.verbatim == b.verbatim, "another line that was kept");
}

void ReadWriteRead(std::string_view text, const ReadOptions& options) {
  ReadReport report;
  const Result<AnyGraphFile> file = ParseG2o(text, "f", options, &report);
  if (!file.ok()) {
    Require(file.status().code() == StatusCode::kMalformed, "an error of another kind");
    Require(file.status().message().substr(0, 2) == "f:", file.status().message());
    Require(file.status().message().size() < 500, "a message that is too long");
    return;
  }
  std::string written;
  const Status status = FormatG2o(*file, WriteOptions(), &written);
  Require(status.ok(), status.message());
  const Result<AnyGraphFile> again = ParseG2o(written, "again", ReadOptions(), nullptr);
  Require(again.ok(), again.status().message() + "\n" + written);
  Require(file->index() == again->index(), "another dimension");
  std::visit(
      [&](const auto& first) {
        RequireSame(first, std::get<std::decay_t<decltype(first)>>(*again));
      },
      *file);
  std::string twice;
  Require(FormatG2o(*again, WriteOptions(), &twice).ok(), "cannot be written again");
  Require(written == twice, "another text:\n" + written + "and then:\n" + twice);
}

}  // namespace
}  // namespace hpgo

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  hpgo::ReadWriteRead(text, hpgo::OptionsOf(data[0]));
  return 0;
}
