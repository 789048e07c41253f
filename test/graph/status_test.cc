#include "hpgo/graph/status.h"

#include <memory>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

TEST(StatusTest, IsOkUnlessTold) {
  EXPECT_TRUE(Status().ok());
  EXPECT_TRUE(Status::Ok().ok());
  EXPECT_EQ(Status::Ok().ToString(), "ok");
  EXPECT_EQ(Status::Ok().message(), "");
}

TEST(StatusTest, NamesItsCodeAndMessage) {
  const Status status(StatusCode::kNotFound, "no node 7");
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_EQ(status.message(), "no node 7");
  EXPECT_EQ(status.ToString(), "not found: no node 7");
}

TEST(StatusTest, EveryCodeHasItsName) {
  EXPECT_STREQ(StatusCodeName(StatusCode::kOk), "ok");
  EXPECT_STREQ(StatusCodeName(StatusCode::kInvalidArgument), "invalid argument");
  EXPECT_STREQ(StatusCodeName(StatusCode::kNotFound), "not found");
  EXPECT_STREQ(StatusCodeName(StatusCode::kAlreadyExists), "already exists");
  EXPECT_STREQ(StatusCodeName(StatusCode::kUnreadable), "unreadable");
  EXPECT_STREQ(StatusCodeName(StatusCode::kMalformed), "malformed");
  EXPECT_STREQ(StatusCodeName(StatusCode::kNoSolution), "no solution");
  EXPECT_STREQ(StatusCodeName(StatusCode::kInterrupted), "interrupted");
}

TEST(ResultTest, HoldsAValueOrAStatus) {
  Result<std::string> value(std::string("five"));
  ASSERT_TRUE(value.ok());
  EXPECT_TRUE(value.status().ok());
  EXPECT_EQ(value.value(), "five");
  EXPECT_EQ(value->size(), 4u);
  *value += "!";
  EXPECT_EQ(*value, "five!");

  const Result<std::string> error(Status(StatusCode::kMalformed, "line 3"));
  EXPECT_FALSE(error.ok());
  EXPECT_EQ(error.status().ToString(), "malformed: line 3");
  EXPECT_THROW(static_cast<void>(error.value()), std::bad_optional_access);
}

TEST(ResultTest, MovesItsValueOut) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 5);
}

}  // namespace
}  // namespace hpgo
