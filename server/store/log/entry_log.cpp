#include "store/log/entry_log.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "store/log/checksum.h"

namespace tessera::server {
namespace {

constexpr std::uint32_t kMagic = 0x474c5354;  // "TSLG"

struct FrameHeader {
  std::uint32_t magic = kMagic;
  std::uint32_t entry_bytes = 0;
  std::uint64_t commit = 0;
  std::uint32_t epoch = 0;
  std::uint32_t entries = 0;
  std::uint32_t index = 0;
  std::uint32_t zero = 0;
  std::uint64_t checksum = 0;
};
static_assert(sizeof(FrameHeader) == 40, "has no padding: it is written as it lies in memory");

std::uint64_t checksum_of(FrameHeader header, std::string_view entry, std::uint64_t place) {
  header.checksum = place;
  return checksum(entry, checksum({reinterpret_cast<const char*>(&header), sizeof(header)}, /*seed=*/0));
}

}  // namespace

absl::Status EntryLog::open() {
  if (file_ != nullptr) return absl::OkStatus();
  auto opened = disk_.open(path_, /*create=*/true);
  if (!opened.ok()) return opened.status();
  file_ = *std::move(opened);
  return absl::OkStatus();
}

void EntryLog::append(const CommitStamp& stamp, const JournalEntry& entry, const PayloadPlace& payload) {
  const std::string bytes = entry_bytes(entry, payload);
  FrameHeader header{.entry_bytes = static_cast<std::uint32_t>(bytes.size()),
                     .commit = stamp.commit,
                     .epoch = stamp.epoch,
                     .entries = stamp.entries,
                     .index = stamp.index};
  header.checksum = checksum_of(header, bytes, appended_);
  buffer_.append(reinterpret_cast<const char*>(&header), sizeof(header));
  buffer_ += bytes;
  appended_ += sizeof(header) + bytes.size();
}

absl::Status EntryLog::flush() {
  const std::string bytes = std::exchange(buffer_, {});
  return bytes.empty() ? absl::OkStatus() : file_->write_at(appended_ - bytes.size(), bytes);
}

void EntryLog::drop() {
  buffer_.clear();
  // Where it cannot be cut off, the next start sees that the commit is not complete.
  if (file_ != nullptr && appended_ > kept_) static_cast<void>(file_->truncate(kept_));
  appended_ = kept_;
}

absl::StatusOr<std::uint64_t> read_log(Disk& disk, const std::filesystem::path& path, std::uint64_t from,
                                       const std::function<bool(LogFrame)>& visit) {
  const auto file = disk.open(path, /*create=*/false);
  if (absl::IsNotFound(file.status())) return 0;
  if (!file.ok()) return file.status();
  const absl::StatusOr<std::uint64_t> size = (*file)->size();
  if (!size.ok()) return size.status();
  if (*size <= from) return from;
  std::string bytes(*size - from, '\0');
  if (absl::Status status = (*file)->read_at(from, bytes.data(), bytes.size()); !status.ok()) return status;

  std::uint64_t at = 0;
  while (bytes.size() - at >= sizeof(FrameHeader)) {
    FrameHeader header;
    std::memcpy(&header, bytes.data() + at, sizeof(header));
    const std::uint64_t room = bytes.size() - at - sizeof(header);
    if (header.magic != kMagic || header.entry_bytes > room) break;
    const std::string_view entry(bytes.data() + at + sizeof(header), header.entry_bytes);
    if (header.checksum != checksum_of(header, entry, from + at)) break;
    std::optional<LoggedEntry> logged = entry_from_bytes(entry);
    if (!logged) break;
    const std::uint64_t next = at + sizeof(header) + entry.size();
    const CommitStamp stamp{
        .commit = header.commit, .epoch = header.epoch, .entries = header.entries, .index = header.index};
    if (!visit({.stamp = stamp, .logged = *std::move(logged), .begin = from + at, .end = from + next})) break;
    at = next;
  }
  return from + at;
}

}  // namespace tessera::server
