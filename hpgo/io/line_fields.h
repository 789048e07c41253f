// The fields of one line of text, and numbers read and written without a locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hpgo {

// Walks over the fields of a line. A '#' at the beginning of a field starts a comment: the line
// ends there. Keeps views into the line.
class LineFields {
 public:
  explicit LineFields(std::string_view line) : next_(line.data()), end_(next_ + line.size()) {}

  // The next field; empty at the end of the line.
  std::string_view Word();
  bool AtEnd();
  // The next field as a number in decimal notation, with an optional sign. False at the end of the
  // line and for anything else: nan, inf, a decimal comma, a number that does not fit; then
  // `what_failed` and `failed_field` say why.
  bool Read(double* value);
  bool Read(std::int64_t* value);

  // "not a number", say; empty where the line ended early.
  const char* what_failed() const { return what_failed_; }
  std::string_view failed_field() const { return failed_field_; }

 private:
  void SkipSpaces();
  bool Fail(const char* what, const char* field);

  const char* next_;
  const char* end_;
  const char* what_failed_ = "";
  std::string_view failed_field_;
};

int CountFields(std::string_view line);
// The text from field `first`, counted from zero, to the end of field `first + count - 1`.
std::string_view FieldSpan(std::string_view line, int first, int count);

// The text shortened and free of control characters, for a message; Quoted: in quotes.
std::string Shortened(std::string_view text);
std::string Quoted(std::string_view text);

// The shortest decimal that reads back as the same number, bit for bit.
void AppendNumber(double value, std::string* text);
void AppendNumber(std::int64_t value, std::string* text);

// A number for a message, with six significant digits.
std::string ShortNumber(double value);

}  // namespace hpgo
