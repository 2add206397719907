#include "store/disk.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "absl/strings/str_cat.h"
#include "store/file.h"
#include "store/sqlite/checked_pages.h"

namespace tessera::server {
namespace {

// Most syncs under way at a time. A journaling file system writes its log once for all that wait for it, so
// that sixteen take little longer than one [docs/decisions/0015-load.md].
constexpr std::size_t kSyncsAtATime = 16;

class MachineFile final : public DiskFile {
 public:
  explicit MachineFile(File file) : file_(std::move(file)) {}
  absl::StatusOr<std::uint64_t> size() const override { return file_.size(); }
  absl::Status write_at(std::uint64_t offset, std::string_view bytes) override {
    return file_.write_at(offset, bytes);
  }
  absl::Status read_at(std::uint64_t offset, char* out, std::size_t size) const override {
    return file_.read_at(offset, out, size);
  }
  absl::Status truncate(std::uint64_t size) override { return file_.truncate(size); }
  absl::Status sync() override { return file_.sync(); }

 private:
  File file_;
};

class MachineDisk final : public Disk {
 public:
  absl::StatusOr<std::unique_ptr<DiskFile>> open(const std::filesystem::path& path, bool create) override {
    absl::StatusOr<File> file = create ? File::open_or_create(path) : File::open_existing(path);
    if (!file.ok()) return file.status();
    return std::make_unique<MachineFile>(*std::move(file));
  }
  absl::Status remove(const std::filesystem::path& path) override {
    std::error_code error;
    std::filesystem::remove(path, error);
    return error ? absl::ErrnoToStatus(error.value(), absl::StrCat("remove ", path.string()))
                 : absl::OkStatus();
  }
  absl::Status move(const std::filesystem::path& from, const std::filesystem::path& to) override {
    const absl::Status status = rename_file(from, to);
    return absl::IsNotFound(status) ? absl::OkStatus() : status;
  }
  absl::StatusOr<std::vector<std::string>> list(const std::filesystem::path& directory) override {
    std::vector<std::string> names;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
      names.push_back(entry->path().filename().string());
    }
    if (error && error != std::errc::no_such_file_or_directory) {
      return absl::ErrnoToStatus(error.value(), absl::StrCat("look into ", directory.string()));
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  absl::Status sync(const std::vector<DiskFile*>& files) override {
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    absl::Status status;
    const auto sync_some = [&] {
      for (std::size_t i; (i = next++) < files.size();) {
        const absl::Status synced = files[i]->sync();
        const std::lock_guard lock(mutex);
        status.Update(synced);
      }
    };
    std::vector<std::jthread> helpers;
    while (helpers.size() + 1 < std::min(files.size(), kSyncsAtATime)) helpers.emplace_back(sync_some);
    sync_some();
    helpers.clear();
    return status;
  }
  absl::Status sync_directory(const std::filesystem::path& directory) override {
    return server::sync_directory(directory);
  }
  std::string sqlite_vfs() const override { return checked_pages_vfs(); }
};

}  // namespace

absl::Status Disk::sync(const std::vector<DiskFile*>& files) {
  for (DiskFile* const file : files) {
    if (absl::Status status = file->sync(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

Disk& machine_disk() {
  static MachineDisk disk;
  return disk;
}

}  // namespace tessera::server
