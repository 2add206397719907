// Logs of journal entries, and the manifest beside them.
#include "store/log/entry_log.h"

#include <gtest/gtest.h>

#include <fstream>

#include "store/log/manifest.h"
#include "support/process/temp_dir.h"

namespace tessera::server {
namespace {

/// One of each kind, with no field as it is by itself.
std::vector<JournalEntry> all_kinds() {
  return {JobAdded{"a", "request", std::string("spec\0with a zero", 16), 2, 1'700'000'000'000, 12},
          JobBound{"a", "avx2"},
          JobEnded{"a", 3, "why", 17},
          UnitDone{"a", 5, {6, 4}, "digest", "", "stats", "host"},
          JobStats{"a", 5, "of five"},
          SchedulerEvent{"a", 4, 7, -8, "host", "text"},
          JobReopened{"a"},
          JobFetched{"a"},
          JobPruned{"a"}};
}

class EntryLogTest : public testing::Test {
 protected:
  std::filesystem::path path() const { return directory_.path() / "log"; }

  void flip_a_bit(std::uint64_t at) const {
    std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(at));
    const int byte = file.get();
    file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte ^ (1 << at % 8)));
  }

  void write(const std::vector<JournalEntry>& entries) const {
    EntryLog log(machine_disk(), path(), 0);
    ASSERT_TRUE(log.open().ok());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      log.append({.commit = 7, .epoch = 3, .entries = 9, .index = static_cast<std::uint32_t>(i)}, entries[i],
                 {.end = 100 + i, .bytes = 10, .sum = 1});
    }
    ASSERT_TRUE(log.flush().ok());
  }

  std::vector<LogFrame> read() const {
    std::vector<LogFrame> frames;
    EXPECT_TRUE(read_log(machine_disk(), path(), 0, [&](LogFrame frame) {
                  frames.push_back(std::move(frame));
                  return true;
                }).ok());
    return frames;
  }

  support::TempDir directory_;
};

TEST_F(EntryLogTest, KeepsEveryKindOfEntry) {
  const std::vector<JournalEntry> entries = all_kinds();
  ASSERT_EQ(entries.size(), std::variant_size_v<JournalEntry>);
  write(entries);
  const std::vector<LogFrame> frames = read();
  ASSERT_EQ(frames.size(), entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ(frames[i].logged.entry.index(), i);
    EXPECT_EQ(entry_bytes(frames[i].logged.entry, {}), entry_bytes(entries[i], {}));
    EXPECT_EQ(frames[i].logged.payload.end, 100 + i);
    EXPECT_EQ(frames[i].stamp.commit, 7u);
    EXPECT_EQ(frames[i].stamp.index, i);
    EXPECT_EQ(log_of(entries[i]), i + 1 == entries.size() ? "" : "a")
        << "deleted jobs are remembered by the farm's log";
  }
  const auto& added = std::get<JobAdded>(frames[0].logged.entry);
  EXPECT_EQ(added.spec.size(), 16u);
  EXPECT_EQ(std::get<SchedulerEvent>(frames[5].logged.entry).value, -8);
}

TEST_F(EntryLogTest, EndsWhereABitHasFlippedOrTheFileIsCut) {
  write(all_kinds());
  const std::vector<LogFrame> whole = read();
  const auto frames_before = [&](std::uint64_t byte) {
    return static_cast<std::size_t>(
        std::count_if(whole.begin(), whole.end(), [&](const LogFrame& frame) { return frame.end <= byte; }));
  };
  for (std::uint64_t byte = 0; byte < whole.back().end; ++byte) {
    flip_a_bit(byte);
    EXPECT_EQ(read().size(), frames_before(byte)) << "byte " << byte;
    flip_a_bit(byte);
  }
  for (std::uint64_t size = whole.back().end; size-- > 0;) {
    std::filesystem::resize_file(path(), size);
    EXPECT_EQ(read().size(), frames_before(size));
  }
}

TEST_F(EntryLogTest, AManifestWithATornSlotHasTheOther) {
  {
    auto manifest = Manifest::open(machine_disk(), path()).value();
    EXPECT_FALSE(manifest.found());
    for (std::uint64_t commit : {1, 2, 3})
      ASSERT_TRUE(manifest.write({.commit = commit, .jobs = 10 * commit}).ok());
  }
  EXPECT_EQ(Manifest::open(machine_disk(), path())->found()->jobs, 30u);
  const std::uint64_t size = std::filesystem::file_size(path());
  for (std::uint64_t byte = 0; byte < size; ++byte) {
    flip_a_bit(byte);
    const auto manifest = Manifest::open(machine_disk(), path());
    ASSERT_TRUE(manifest->found()) << "byte " << byte;
    EXPECT_GE(manifest->found()->commit, 2u);
    EXPECT_EQ(manifest->found()->jobs, 10 * manifest->found()->commit);
    flip_a_bit(byte);
  }
  std::filesystem::resize_file(path(), 40);
  EXPECT_FALSE(Manifest::open(machine_disk(), path())->found());
}

}  // namespace
}  // namespace tessera::server
