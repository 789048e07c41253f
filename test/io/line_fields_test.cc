#include "hpgo/io/line_fields.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

double NumberOf(const std::string& text) {
  double value = std::nan("");
  LineFields fields(text);
  EXPECT_TRUE(fields.Read(&value)) << text;
  EXPECT_TRUE(fields.AtEnd()) << text;
  return value;
}

std::string FailureOf(const std::string& text) {
  double value = 0;
  LineFields fields(text);
  if (fields.Read(&value)) return "";
  return fields.what_failed() + std::string("|") + std::string(fields.failed_field());
}

TEST(LineFields, ReadsNumbersInEveryUsualForm) {
  EXPECT_EQ(NumberOf("1"), 1);
  EXPECT_EQ(NumberOf("+1.5"), 1.5);
  EXPECT_EQ(NumberOf("-.5"), -0.5);
  EXPECT_EQ(NumberOf("2."), 2);
  EXPECT_EQ(NumberOf("1e3"), 1000);
  EXPECT_EQ(NumberOf("1E+3"), 1000);
  EXPECT_EQ(NumberOf(" \t1e-3\r"), 1e-3);
  EXPECT_EQ(NumberOf("4.9406564584124654e-324"), std::numeric_limits<double>::denorm_min());
  EXPECT_TRUE(std::signbit(NumberOf("-0")));
}

TEST(LineFields, RejectsWhatIsNoFiniteNumber) {
  EXPECT_EQ(FailureOf("nan 1"), "not a finite number|nan");
  EXPECT_EQ(FailureOf("-NaN"), "not a finite number|-NaN");
  EXPECT_EQ(FailureOf("inf"), "not a finite number|inf");
  EXPECT_EQ(FailureOf("+infinity"), "not a finite number|+infinity");
  EXPECT_EQ(FailureOf("1e999"), "number out of range|1e999");
  EXPECT_EQ(FailureOf("0,5 1"), "not a number|0,5");
  EXPECT_EQ(FailureOf("1.5x"), "not a number|1.5x");
  EXPECT_EQ(FailureOf("1.2.3"), "not a number|1.2.3");
  EXPECT_EQ(FailureOf("0x10"), "not a number|0x10");
  EXPECT_EQ(FailureOf("--1"), "not a number|--1");
  EXPECT_EQ(FailureOf("+-1"), "not a number|+-1");
  EXPECT_EQ(FailureOf("++1"), "not a number|++1");
  EXPECT_EQ(FailureOf("+"), "not a number|+");
  EXPECT_EQ(FailureOf("abc"), "not a number|abc");
  EXPECT_EQ(FailureOf("  "), "|");
  EXPECT_EQ(FailureOf("# 1"), "|");
}

TEST(LineFields, ReadsIdsOf64Bits) {
  std::int64_t id = 0;
  EXPECT_TRUE(LineFields("9223372036854775807").Read(&id));
  EXPECT_EQ(id, std::numeric_limits<std::int64_t>::max());
  EXPECT_TRUE(LineFields("-9223372036854775808").Read(&id));
  EXPECT_EQ(id, std::numeric_limits<std::int64_t>::min());
  LineFields beyond("9223372036854775808");
  EXPECT_FALSE(beyond.Read(&id));
  EXPECT_STREQ(beyond.what_failed(), "id beyond 64 bits");
  LineFields fraction("1.0");
  EXPECT_FALSE(fraction.Read(&id));
  EXPECT_STREQ(fraction.what_failed(), "not an id");
}

TEST(LineFields, WalksOverWordsUpToAComment) {
  LineFields fields("  one\ttwo  # three");
  EXPECT_EQ(fields.Word(), "one");
  EXPECT_EQ(fields.Word(), "two");
  EXPECT_EQ(fields.Word(), "");
  EXPECT_TRUE(fields.AtEnd());
  EXPECT_EQ(CountFields(" a  b c \r"), 3);
  EXPECT_EQ(FieldSpan("a b  c d", 1, 2), "b  c");
  EXPECT_EQ(FieldSpan("a b", 1, 5), "b");
}

TEST(LineFields, QuotesShortAndPrintable) {
  EXPECT_EQ(Quoted("a\tb\x01 \r"), "'a b?'");
  EXPECT_EQ(Quoted(std::string(200, 'x')), "'" + std::string(70, 'x') + "...'");
}

TEST(LineFields, NumbersReadBackBitForBit) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 20000; ++k) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) continue;
    std::string text;
    AppendNumber(value, &text);
    const double again = NumberOf(text);
    EXPECT_EQ(std::memcmp(&again, &value, sizeof(value)), 0) << text;
  }
}

TEST(LineFields, ShortNumbersHaveSixDigits) {
  EXPECT_EQ(ShortNumber(1.0 / 3), "0.333333");
  EXPECT_EQ(ShortNumber(-2), "-2");
}

}  // namespace
}  // namespace hpgo
