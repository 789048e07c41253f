#include "hpgo/io/line_fields.h"

#include <charconv>
#include <cmath>

namespace hpgo {
namespace {

constexpr std::size_t kMaxQuoted = 70;

bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// from_chars takes no plus sign. A second sign stays, to be rejected.
const char* SkipPlus(const char* begin, const char* end) {
  const bool plus = end - begin > 1 && *begin == '+' && begin[1] != '-';
  return plus ? begin + 1 : begin;
}

}  // namespace

void LineFields::SkipSpaces() {
  while (next_ < end_ && IsSpace(*next_)) ++next_;
  if (next_ < end_ && *next_ == '#') next_ = end_;
}

std::string_view LineFields::Word() {
  SkipSpaces();
  const char* begin = next_;
  while (next_ < end_ && !IsSpace(*next_)) ++next_;
  return std::string_view(begin, static_cast<std::size_t>(next_ - begin));
}

bool LineFields::AtEnd() {
  SkipSpaces();
  return next_ == end_;
}

bool LineFields::Fail(const char* what, const char* field) {
  next_ = field;
  what_failed_ = what;
  failed_field_ = Word();
  return false;
}

bool LineFields::Read(double* value) {
  if (AtEnd()) return Fail("", next_);
  const char* const begin = next_;
  const std::from_chars_result result = std::from_chars(SkipPlus(begin, end_), end_, *value);
  if (result.ec == std::errc::result_out_of_range) return Fail("number out of range", begin);
  if (result.ec != std::errc()) return Fail("not a number", begin);
  if (result.ptr < end_ && !IsSpace(*result.ptr)) return Fail("not a number", begin);
  if (!std::isfinite(*value)) return Fail("not a finite number", begin);
  next_ = result.ptr;
  return true;
}

bool LineFields::Read(std::int64_t* value) {
  if (AtEnd()) return Fail("", next_);
  const char* const begin = next_;
  const std::from_chars_result result = std::from_chars(SkipPlus(begin, end_), end_, *value);
  if (result.ec == std::errc::result_out_of_range) return Fail("id beyond 64 bits", begin);
  if (result.ec != std::errc()) return Fail("not an id", begin);
  if (result.ptr < end_ && !IsSpace(*result.ptr)) return Fail("not an id", begin);
  next_ = result.ptr;
  return true;
}

int CountFields(std::string_view line) {
  LineFields fields(line);
  int count = 0;
  while (!fields.Word().empty()) ++count;
  return count;
}

std::string_view FieldSpan(std::string_view line, int first, int count) {
  LineFields fields(line);
  const char* begin = line.data();
  const char* end = begin;
  for (int k = 0; k < first + count; ++k) {
    const std::string_view word = fields.Word();
    if (word.empty()) break;
    if (k == first) begin = word.data();
    end = word.data() + word.size();
  }
  return end > begin ? std::string_view(begin, static_cast<std::size_t>(end - begin)) : line;
}

std::string Shortened(std::string_view text) {
  while (!text.empty() && IsSpace(text.back())) text.remove_suffix(1);
  const bool shortened = text.size() > kMaxQuoted;
  std::string result;
  for (char c : text.substr(0, kMaxQuoted)) {
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    result += control ? (c == '\t' ? ' ' : '?') : c;
  }
  return shortened ? result + "..." : result;
}

std::string Quoted(std::string_view text) { return "'" + Shortened(text) + "'"; }

void AppendNumber(double value, std::string* text) {
  char buffer[32];
  text->append(buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
}

void AppendNumber(std::int64_t value, std::string* text) {
  char buffer[24];
  text->append(buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
}

std::string ShortNumber(double value) {
  char buffer[32];
  return std::string(
      buffer,
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::general, 6).ptr);
}

}  // namespace hpgo
