#include "image/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "unit/client/files.h"

namespace tessera::client {
namespace {

TEST(AtomicFile, WritesTheBytes) {
  const support::TempDir directory;
  const std::string bytes("a\0b", 3);
  ASSERT_TRUE(replace_file_with(directory / "file", bytes).ok());
  EXPECT_EQ(read_bytes(directory / "file"), bytes);
  EXPECT_EQ(file_count(directory), 1u);
}

TEST(AtomicFile, KeepsTheOldFileWhenWritingFails) {
  const support::TempDir directory;
  write_bytes(directory / "file", "old");
  const absl::Status status = replace_file(directory / "file", [](const std::string& temporary) {
    write_bytes(temporary, "half of the n");
    return absl::DataLossError("out of luck");
  });
  EXPECT_EQ(status, absl::DataLossError("out of luck"));
  EXPECT_EQ(read_bytes(directory / "file"), "old");
  EXPECT_EQ(file_count(directory), 1u);
}

TEST(AtomicFile, GivesTheFileTheUsualPermissions) {
  const support::TempDir directory;
  const mode_t mask = umask(022);
  ASSERT_TRUE(replace_file_with(directory / "file", "x").ok());
  umask(mask);
  struct stat info {};
  ASSERT_EQ(stat((directory / "file").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0644u);
}

TEST(AtomicFile, NamesThePathInErrors) {
  const support::TempDir directory;
  const absl::Status missing = replace_file_with(directory / "no/such/file", "x");
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(std::string(missing.message()).starts_with(directory / "no/such/file")) << missing;
  const absl::Status taken = replace_file_with(directory / "", "x");
  EXPECT_EQ(taken.code(), absl::StatusCode::kInvalidArgument) << taken;
}

TEST(AtomicFile, WritesToDevicesInPlace) {
  EXPECT_TRUE(replace_file_with("/dev/null", "x").ok());
  struct stat info {};
  ASSERT_EQ(stat("/dev/null", &info), 0);
  EXPECT_TRUE(S_ISCHR(info.st_mode));
}

}  // namespace
}  // namespace tessera::client
