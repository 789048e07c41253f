#include "hpgo/report/svg.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;

TEST(SvgNumberTest, HasAtMostOneDecimal) {
  EXPECT_EQ(SvgNumber(0), "0");
  EXPECT_EQ(SvgNumber(-0.01), "0");
  EXPECT_EQ(SvgNumber(12), "12");
  EXPECT_EQ(SvgNumber(12.34), "12.3");
  EXPECT_EQ(SvgNumber(-12.36), "-12.4");
  EXPECT_EQ(SvgNumber(0.5), ".5");
  EXPECT_EQ(SvgNumber(-0.5), "-.5");
}

TEST(SvgEscapeTest, ReplacesMarkupAndControlCharacters) {
  EXPECT_EQ(SvgEscape("a<b & \"c\">\t\x01"), "a&lt;b &amp; &quot;c&quot;&gt;  ");
  EXPECT_EQ(SvgEscape("größe"), "größe");
}

TEST(SvgPathTest, WritesRelativeSteps) {
  SvgPath path;
  EXPECT_TRUE(path.empty());
  path.MoveTo({10, 20});
  path.LineTo({11.5, 19});
  path.LineTo({12, 19.5});
  path.MoveTo({0, 0});
  path.LineTo({-1, 1});
  EXPECT_EQ(path.data(), "m10 20l1.5-1 .5 .5m-12-19.5l-1 1");
}

TEST(SvgPathTest, LeavesOutPointsThatRoundToTheLast) {
  SvgPath path;
  path.MoveTo({1, 1});
  path.LineTo({1.04, 0.96});
  EXPECT_EQ(path.data(), "m1 1");
}

TEST(SvgPathTest, KeepsASegmentWithoutLength) {
  SvgPath path;
  path.Segment({1, 1}, {1, 1});
  EXPECT_EQ(path.data(), "m1 1l0 0");
}

TEST(SvgPathTest, RoundingErrorsDoNotAddUp) {
  SvgPath path;
  path.MoveTo({0, 0});
  for (int k = 1; k <= 300; ++k) path.LineTo({k * 0.133, 0});
  path.MoveTo({0, 0});
  // Back by the rounded position of the last point, 39.9.
  EXPECT_THAT(path.data(), HasSubstr("m-39.9 0"));
}

TEST(SvgDocumentTest, EscapesTheTitle) {
  const std::string svg = SvgDocument(100, 50, "a<b", "");
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 100 50\""));
  EXPECT_THAT(svg, HasSubstr("<title>a&lt;b</title>"));
}

}  // namespace
}  // namespace hpgo
