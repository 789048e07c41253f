#include "tools/read_graph.h"

#include "hpgo/io/g2o_reader.h"
#include "tools/common_flags.h"
#include "tools/console.h"

namespace hpgo_cli {

hpgo::ReadOptions ReadOptionsFromFlags() {
  hpgo::ReadOptions options;
  options.strict = FLAGS_strict;
  options.project_information = FLAGS_project_information;
  options.identity_information = FLAGS_identity_information;
  options.create_missing = FLAGS_create_missing;
  if (FLAGS_row_major_edge2) options.edge2_order = hpgo::Edge2Order::kRowMajor;
  return options;
}

hpgo::Result<hpgo::AnyGraphFile> ReadGraph(const std::string& path, hpgo::ReadReport* report) {
  hpgo::ReadReport local;
  hpgo::ReadReport* const filled = report != nullptr ? report : &local;
  hpgo::Result<hpgo::AnyGraphFile> file = hpgo::ReadG2o(path, ReadOptionsFromFlags(), filled);
  for (const std::string& warning : filled->warnings) Warn(warning);
  return file;
}

}  // namespace hpgo_cli
