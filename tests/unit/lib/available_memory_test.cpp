#include "base/available_memory.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/process/temp_dir.h"

namespace tessera::base {
namespace {

class AvailableMemory : public testing::Test {
 protected:
  void write(const std::string& path, const std::string& text) {
    const std::filesystem::path file = root() + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::string root() { return folder_.path() / "root"; }

 private:
  const support::TempDir folder_;
};

TEST_F(AvailableMemory, IsThatOfTheMachine) {
  EXPECT_EQ(available_memory(root()), UINT64_MAX);
  write("/proc/meminfo", "MemTotal: 4000 kB\nMemAvailable:     3000 kB\nSwapFree: 7 kB\n");
  EXPECT_EQ(available_memory(root()), 3000u * 1024);
}

TEST_F(AvailableMemory, IsWhatControlGroupsLeave) {
  write("/proc/meminfo", "MemAvailable:     3000 kB\n");
  write("/proc/self/cgroup", "1:name=systemd:/elsewhere\n0::/jobs/seven\n");
  write("/sys/fs/cgroup/jobs/seven/memory.max", "max\n");
  write("/sys/fs/cgroup/jobs/seven/memory.current", "500\n");
  EXPECT_EQ(available_memory(root()), 3000u * 1024);
  write("/sys/fs/cgroup/jobs/memory.max", "2000\n");
  write("/sys/fs/cgroup/jobs/memory.current", "500\n");
  EXPECT_EQ(available_memory(root()), 1500u);
  write("/sys/fs/cgroup/memory.max", "400\n");
  write("/sys/fs/cgroup/memory.current", "500\n");
  EXPECT_EQ(available_memory(root()), 0u);
}

}  // namespace
}  // namespace tessera::base
