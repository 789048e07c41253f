#include "hpgo/io/g2o_reader.h"

#include <utility>

#include "hpgo/io/g2o_parser.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/text_format.h"

namespace hpgo {
namespace {

// That of the first record which has one; 0 if there is none.
int Dimension(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    LineFields fields(text.substr(0, end));
    const int dimension = FindRecordTag(fields.Word()).dimension;
    if (dimension != 0) return dimension;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return 0;
}

// What a text is of which no line is a record; empty if it looks like nothing known.
std::string DescribeOther(std::string_view text) {
  const std::string binary = DescribeBinary(text);
  return binary.empty() ? DescribeText(text) : binary;
}

template <typename G>
Result<AnyGraphFile> ParseAs(std::string_view text, const std::string& name,
                             const ReadOptions& options, ReadReport* report) {
  GraphFile<G> file;
  const Status status = G2oParser<G>(text, name, options).Parse(&file, report);
  if (!status.ok()) return status;
  return AnyGraphFile(std::move(file));
}

}  // namespace

Result<AnyGraphFile> ParseG2o(std::string_view text, const std::string& name,
                              const ReadOptions& options, ReadReport* report) {
  ReadReport unused;
  if (report == nullptr) report = &unused;
  text = WithoutByteOrderMark(text);
  const int dimension = Dimension(text);
  const std::string other = dimension == 0 ? DescribeOther(text) : "";
  if (!other.empty()) {
    MessageLog log(name, options);
    log.Error(0, other, {});
    report->bytes = static_cast<std::int64_t>(text.size());
    return log.Finish(report);
  }
  return dimension == 2 ? ParseAs<SE2>(text, name, options, report)
                        : ParseAs<SE3>(text, name, options, report);
}

Result<AnyGraphFile> ReadG2o(const std::string& path, const ReadOptions& options,
                             ReadReport* report) {
  const Result<InputText> input = InputText::Read(path);
  if (!input.ok()) return input.status();
  return ParseG2o(input->text(), input->name(), options, report);
}

}  // namespace hpgo
