// Short names for what the tests of the readers do with texts.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/io/g2o_reader.h"

namespace hpgo {

// Reads `text` as a file called "f". The report may be looked at afterwards.
inline Result<AnyGraphFile> ReadText(const std::string& text,
                                     const ReadOptions& options = ReadOptions(),
                                     ReadReport* report = nullptr) {
  return ParseG2o(text, "f", options, report);
}

// The message of the error that `text` gives; "" if it gives none or one of another code.
inline std::string ErrorOf(const std::string& text, const ReadOptions& options = ReadOptions()) {
  const Result<AnyGraphFile> file = ReadText(text, options);
  const bool malformed = !file.ok() && file.status().code() == StatusCode::kMalformed;
  return malformed ? file.status().message() : "";
}

inline std::vector<std::string> WarningsOf(const std::string& text,
                                           const ReadOptions& options = ReadOptions()) {
  ReadReport report;
  const Result<AnyGraphFile> file = ReadText(text, options, &report);
  EXPECT_TRUE(file.ok()) << file.status().message();
  return report.warnings;
}

// The file that `text` is; a failed test, and an empty file, if it is none of this dimension.
template <typename G>
GraphFile<G> FileOf(const std::string& text, const ReadOptions& options = ReadOptions()) {
  Result<AnyGraphFile> file = ReadText(text, options);
  EXPECT_TRUE(file.ok()) << file.status().message();
  if (!file.ok() || !std::holds_alternative<GraphFile<G>>(*file)) {
    ADD_FAILURE() << "no graph of dimension " << G::kDim;
    return GraphFile<G>();
  }
  return std::get<GraphFile<G>>(std::move(*file));
}

}  // namespace hpgo
