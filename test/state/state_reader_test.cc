// What the reader says of blocks that are not what is asked for. Files of them have checksums;
// these are the errors of a state that another program has written.

#include "hpgo/state/state_reader.h"

#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ceres_costs/losses.h"
#include "gtest/gtest.h"
#include "hpgo/state/state_writer.h"

namespace hpgo {
namespace {

using Loss = std::shared_ptr<const ceres::LossFunction>;

class StateReaderTest : public testing::Test {
 protected:
  StateReader::Source Source() {
    return [this]() -> Result<StateReader::Block> {
      if (next_ == blocks_.size()) return StateReader::Block();
      const auto& block = blocks_[next_++];
      return StateReader::Block{block.first, block.second};
    };
  }
  // One section with these values.
  template <typename... Values>
  void Write(const char* section, const Values&... values) {
    StateWriter writer(
        [this](const char* name, std::string_view bytes) { blocks_.emplace_back(name, bytes); });
    writer.Section(section);
    writer(values...);
    ASSERT_TRUE(writer.Finish().ok());
  }
  void ExpectMalformed(StateReader* reader, const std::string& message) {
    const Status status = reader->Finish();
    EXPECT_EQ(status.code(), StatusCode::kMalformed);
    EXPECT_EQ(status.message(), message);
  }

  std::deque<std::pair<std::string, std::string>> blocks_;
  std::size_t next_ = 0;
};

TEST_F(StateReaderTest, NamesTheSectionThatIsNotAsItShouldBe) {
  int a = 1, b = 2;
  Write("first", a, b);
  {
    StateReader reader(Source());
    reader.Section("first");
    reader(a);
    ExpectMalformed(&reader, "the section 'first' holds more than is known");
  }
  next_ = 0;
  {
    StateReader reader(Source());
    reader.Section("first");
    int c = 3;
    reader(a, b, c);
    EXPECT_EQ(c, 0);
    ExpectMalformed(&reader, "the section 'first' ends too early");
  }
  next_ = 0;
  {
    StateReader reader(Source());
    reader.Section("second");
    reader(a);
    EXPECT_EQ(a, 0);
    ExpectMalformed(&reader, "there is no section 'second' where it belongs");
  }
}

// No memory is taken for elements that are not there.
TEST_F(StateReaderTest, ASizeThatIsTooLargeEndsWithTheBytes) {
  Write("sizes", std::uint64_t{1} << 60, 7);
  StateReader reader(Source());
  reader.Section("sizes");
  std::vector<int> values;
  reader(values);
  ExpectMalformed(&reader, "the section 'sizes' ends too early");
}

TEST_F(StateReaderTest, LossesAreSharedByTheirNumbers) {
  std::unique_ptr<ceres::LossFunction> huber;
  std::string error;
  ASSERT_TRUE(ceres_costs::MakeLoss("huber", 2, &huber, &error)) << error;
  const Loss loss = std::move(huber);
  Write("losses", loss, Loss(), loss);
  StateReader reader(Source());
  reader.Section("losses");
  Loss a, b = loss, c;
  reader(a, b, c);
  ASSERT_TRUE(reader.Finish().ok());
  EXPECT_EQ(ceres_costs::NameOfLoss(*a)->name, "huber");
  EXPECT_EQ(b, nullptr);
  EXPECT_EQ(a, c);
}

TEST_F(StateReaderTest, RefusesLossesThatItDoesNotKnow) {
  Loss loss;
  Write("losses", std::uint32_t{1}, std::string("steep"), 2.0);
  {
    StateReader reader(Source());
    reader.Section("losses");
    reader(loss);
    EXPECT_EQ(reader.Finish().code(), StatusCode::kInvalidArgument);
  }
  blocks_.clear();
  next_ = 0;
  Write("losses", std::uint32_t{2});
  {
    StateReader reader(Source());
    reader.Section("losses");
    reader(loss);
    ExpectMalformed(&reader, "the section 'losses' skips a loss");
  }
}

}  // namespace
}  // namespace hpgo
