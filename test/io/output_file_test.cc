#include "hpgo/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

namespace fs = std::filesystem;

class OutputFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(::testing::TempDir()) / ("hpgo_" + name + std::to_string(getpid()));
    fs::create_directory(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t Files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  bool HasUnnamedFiles() const {
    const int fd = open(folder_.c_str(), O_TMPFILE | O_WRONLY, 0600);
    if (fd >= 0) close(fd);
    return fd >= 0;
  }
  static std::string Content(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  fs::path folder_;
};

TEST_F(OutputFileTest, WritesAndReplaces) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "one\n").ok());
  EXPECT_EQ(Content(Path("a")), "one\n");
  ASSERT_TRUE(WriteTextFile(Path("a"), "two\n").ok());
  EXPECT_EQ(Content(Path("a")), "two\n");
  EXPECT_EQ(Files(), 1u);
}

TEST_F(OutputFileTest, LongTextsGoOutInPieces) {
  const std::string line(1000, 'x');
  std::string all;
  OutputFile out(Path("a"));
  for (int k = 0; k < 5000; ++k) {
    out.Append(line);
    all += line;
  }
  ASSERT_TRUE(out.Commit().ok());
  EXPECT_EQ(Content(Path("a")), all);
}

TEST_F(OutputFileTest, NothingChangesBeforeCommit) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  {
    OutputFile out(Path("a"));
    out.Append(std::string(3 << 20, 'x'));
    EXPECT_EQ(Content(Path("a")), "old");
  }
  EXPECT_EQ(Content(Path("a")), "old");
  EXPECT_EQ(Files(), 1u);
}

TEST_F(OutputFileTest, KeepsTheModeOfTheFileItReplaces) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  fs::permissions(Path("a"), fs::perms::owner_read | fs::perms::owner_write);
  ASSERT_TRUE(WriteTextFile(Path("a"), "new").ok());
  EXPECT_EQ(fs::status(Path("a")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(OutputFileTest, FollowsLinks) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  fs::create_symlink(Path("a"), Path("link"));
  ASSERT_TRUE(WriteTextFile(Path("link"), "new").ok());
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(Content(Path("a")), "new");
}

// SIGKILL leaves no time to clean up.
TEST_F(OutputFileTest, NothingIsLeftOfAKilledProcess) {
  if (!HasUnnamedFiles()) GTEST_SKIP() << "no O_TMPFILE in " << folder_;
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  const pid_t child = fork();
  if (child == 0) {
    OutputFile out(Path("a"));
    OutputFile other(Path("b"));
    out.Append(std::string(3 << 20, 'x'));
    raise(SIGKILL);
  }
  int state = 0;
  ASSERT_EQ(waitpid(child, &state, 0), child);
  EXPECT_TRUE(WIFSIGNALED(state));
  EXPECT_EQ(Content(Path("a")), "old");
  EXPECT_EQ(Files(), 1u);
}

TEST_F(OutputFileTest, NewFilesHaveTheModeOfTheMask) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "new").ok());
  const mode_t mask = umask(0);
  umask(mask);
  struct stat info;
  ASSERT_EQ(stat(Path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0666 & ~mask);
}

TEST_F(OutputFileTest, PathsAreCheckedWithoutATrace) {
  EXPECT_TRUE(CheckOutputPath(Path("a")).ok());
  EXPECT_EQ(Files(), 0u);
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  EXPECT_TRUE(CheckOutputPath(Path("a")).ok());
  EXPECT_EQ(Content(Path("a")), "old");
  EXPECT_EQ(Files(), 1u);
  EXPECT_TRUE(CheckOutputPath("-").ok());
  EXPECT_EQ(CheckOutputPath(Path("no/a")).message(),
            Path("no/a") + ": cannot be created: No such file or directory");
  EXPECT_EQ(CheckOutputPath(folder_.string()).message(),
            folder_.string() + ": cannot be written: Is a directory");
  // Opening a pipe that nobody reads would wait for ever.
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(CheckOutputPath(Path("pipe")).ok());
}

TEST_F(OutputFileTest, MissingFolderIsAnError) {
  const Status status = WriteTextFile(Path("no/such/a"), "text");
  EXPECT_EQ(status.code(), StatusCode::kUnreadable);
  EXPECT_EQ(status.message(), Path("no/such/a") + ": cannot be created: No such file or directory");
}

TEST_F(OutputFileTest, AFileIsNoFolder) {
  ASSERT_TRUE(WriteTextFile(Path("a"), "old").ok());
  EXPECT_EQ(WriteTextFile(Path("a/b"), "text").message(),
            Path("a/b") + ": cannot be created: Not a directory");
  EXPECT_EQ(WriteTextFile(folder_.string(), "text").message(),
            folder_.string() + ": cannot be written: Is a directory");
}

TEST_F(OutputFileTest, UnwritableFolderIsAnError) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_EQ(WriteTextFile(Path("a"), "text").message(),
            Path("a") + ": cannot be created: Permission denied");
}

TEST_F(OutputFileTest, FullDeviceIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_EQ(WriteTextFile("/dev/full", "text").message(),
            "/dev/full: cannot be written: No space left on device");
  EXPECT_TRUE(fs::exists("/dev/full"));
}

TEST_F(OutputFileTest, DevicesAreWrittenTo) {
  EXPECT_TRUE(WriteTextFile("/dev/null", "text").ok());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace hpgo
