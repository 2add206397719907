#include "scenario/simulated_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera::server {
namespace {

constexpr char kVfsName[] = "simulated-disk";
SimulatedDisk* the_disk = nullptr;  // SQLite's callbacks work on it

void apply(const SimulatedDisk::Contents::Write& write, std::size_t size, std::string& bytes) {
  if (write.bytes.empty()) {
    bytes.resize(write.offset, '\0');
    return;
  }
  if (bytes.size() < write.offset + size) bytes.resize(write.offset + size, '\0');
  bytes.replace(write.offset, size, write.bytes, 0, size);
}

class SimulatedFile final : public DiskFile {
 public:
  SimulatedFile(SimulatedDisk& disk, std::shared_ptr<SimulatedDisk::Contents> contents)
      : disk_(disk), contents_(std::move(contents)) {}
  absl::StatusOr<std::uint64_t> size() const override { return contents_->bytes.size(); }
  absl::Status write_at(std::uint64_t offset, std::string_view bytes) override {
    return disk_.write(*contents_, offset, bytes);
  }
  absl::Status read_at(std::uint64_t offset, char* out, std::size_t size) const override {
    if (offset + size > contents_->bytes.size()) return absl::DataLossError("the file is too short");
    std::memcpy(out, contents_->bytes.data() + offset, size);
    return absl::OkStatus();
  }
  absl::Status truncate(std::uint64_t size) override { return disk_.truncate(*contents_, size); }
  absl::Status sync() override { return disk_.sync(*contents_); }

 private:
  SimulatedDisk& disk_;
  std::shared_ptr<SimulatedDisk::Contents> contents_;
};

// ---------------------------------------------------------------- SQLite's side [sqlite.org/vfs.html]

/// Memory that SQLite allocates for an open file; `contents` is made and destroyed by hand.
struct VfsFile {
  sqlite3_file base;
  std::shared_ptr<SimulatedDisk::Contents>* contents;
};

SimulatedDisk::Contents& contents_of(sqlite3_file* file) {
  return **reinterpret_cast<VfsFile*>(file)->contents;
}

int code_of(const absl::Status& status, int error) {
  if (status.ok()) return SQLITE_OK;
  return absl::IsResourceExhausted(status) ? SQLITE_FULL : error;
}

int vfs_close(sqlite3_file* file) {
  delete std::exchange(reinterpret_cast<VfsFile*>(file)->contents, nullptr);
  return SQLITE_OK;
}

int vfs_read(sqlite3_file* file, void* out, int size, sqlite3_int64 offset) {
  const std::string& bytes = contents_of(file).bytes;
  const auto at = static_cast<std::size_t>(offset);
  const std::size_t there =
      at >= bytes.size() ? 0 : std::min(bytes.size() - at, static_cast<std::size_t>(size));
  std::memcpy(out, bytes.data() + std::min(at, bytes.size()), there);
  if (there == static_cast<std::size_t>(size)) return SQLITE_OK;
  std::memset(static_cast<char*>(out) + there, 0, static_cast<std::size_t>(size) - there);
  return SQLITE_IOERR_SHORT_READ;
}

int vfs_write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
  return code_of(the_disk->write(contents_of(file), static_cast<std::uint64_t>(offset),
                                 {static_cast<const char*>(bytes), static_cast<std::size_t>(size)}),
                 SQLITE_IOERR_WRITE);
}

int vfs_truncate(sqlite3_file* file, sqlite3_int64 size) {
  return code_of(the_disk->truncate(contents_of(file), static_cast<std::uint64_t>(size)),
                 SQLITE_IOERR_TRUNCATE);
}

int vfs_sync(sqlite3_file* file, int) {
  return code_of(the_disk->sync(contents_of(file)), SQLITE_IOERR_FSYNC);
}

int vfs_size(sqlite3_file* file, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(contents_of(file).bytes.size());
  return SQLITE_OK;
}

int vfs_lock(sqlite3_file*, int) { return SQLITE_OK; }
int vfs_check_lock(sqlite3_file*, int* locked) { return *locked = 0, SQLITE_OK; }
int vfs_control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int vfs_sector_size(sqlite3_file*) { return 512; }
int vfs_characteristics(sqlite3_file*) { return 0; }

int vfs_open(sqlite3_vfs*, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  static const sqlite3_io_methods methods = [] {
    sqlite3_io_methods m{};
    m.iVersion = 1;  // no shared memory: the journal is this process's alone
    m.xClose = vfs_close, m.xRead = vfs_read, m.xWrite = vfs_write, m.xTruncate = vfs_truncate,
    m.xSync = vfs_sync;
    m.xFileSize = vfs_size, m.xLock = vfs_lock, m.xUnlock = vfs_lock, m.xCheckReservedLock = vfs_check_lock;
    m.xFileControl = vfs_control, m.xSectorSize = vfs_sector_size,
    m.xDeviceCharacteristics = vfs_characteristics;
    return m;
  }();
  auto* const opened = reinterpret_cast<VfsFile*>(file);
  auto contents = the_disk->find(name == nullptr ? "(temporary)" : name, (flags & SQLITE_OPEN_CREATE) != 0);
  opened->base.pMethods = nullptr;
  if (contents == nullptr) return SQLITE_CANTOPEN;
  opened->base.pMethods = &methods;
  opened->contents = new std::shared_ptr<SimulatedDisk::Contents>(std::move(contents));
  if (out_flags != nullptr) *out_flags = flags;
  return SQLITE_OK;
}

int vfs_delete(sqlite3_vfs*, const char* name, int) {
  return code_of(the_disk->remove(name), SQLITE_IOERR_DELETE);
}

int vfs_access(sqlite3_vfs*, const char* name, int, int* found) {
  return *found = the_disk->find(name, /*create=*/false) != nullptr, SQLITE_OK;
}

int vfs_full_path(sqlite3_vfs*, const char* name, int size, char* out) {
  return sqlite3_snprintf(size, out, "%s", name), SQLITE_OK;
}

}  // namespace

SimulatedDisk::SimulatedDisk(std::uint64_t seed) : random_(seed) {
  static sqlite3_vfs vfs = [] {
    const sqlite3_vfs* const usual = sqlite3_vfs_find(nullptr);
    sqlite3_vfs v{};
    v.iVersion = 1, v.szOsFile = sizeof(VfsFile), v.mxPathname = 512, v.zName = kVfsName;
    v.xOpen = vfs_open, v.xDelete = vfs_delete, v.xAccess = vfs_access, v.xFullPathname = vfs_full_path;
    v.xRandomness = usual->xRandomness, v.xSleep = usual->xSleep, v.xCurrentTime = usual->xCurrentTime;
    v.xGetLastError = usual->xGetLastError;
    sqlite3_vfs_register(&v, 0);
    return v;
  }();
  sqlite3_vfs_register(&vfs, 0);
  the_disk = this;
}

SimulatedDisk::~SimulatedDisk() { the_disk = nullptr; }

absl::Status SimulatedDisk::operate() {
  if (powered_ && (fail_in_ == 0 || --fail_in_ > 0)) return absl::OkStatus();
  powered_ = false;
  return absl::InternalError("the power failed");
}

absl::Status SimulatedDisk::write(Contents& file, std::uint64_t offset, std::string_view bytes) {
  if (bytes.empty()) return absl::OkStatus();
  const std::uint64_t grown =
      std::max<std::uint64_t>(file.bytes.size(), offset + bytes.size()) - file.bytes.size();
  if (powered_ && used_ + grown > capacity_) return absl::ResourceExhaustedError("the disk is full");
  const bool was_powered = powered_;
  const absl::Status status = operate();
  if (!was_powered) return status;
  // The write in which the power fails may have reached the disk in part, as those before it may.
  file.unsynced.push_back({.offset = offset, .bytes = std::string(bytes)});
  if (!status.ok()) return status;
  used_ += grown;
  apply(file.unsynced.back(), bytes.size(), file.bytes);
  return absl::OkStatus();
}

absl::Status SimulatedDisk::truncate(Contents& file, std::uint64_t size) {
  if (absl::Status status = operate(); !status.ok()) return status;
  used_ -= std::min<std::uint64_t>(used_, file.bytes.size() > size ? file.bytes.size() - size : 0);
  file.unsynced.push_back({.offset = size, .bytes = ""});
  file.bytes.resize(size, '\0');
  return absl::OkStatus();
}

absl::Status SimulatedDisk::sync(Contents& file) {
  if (absl::Status status = operate(); !status.ok()) return status;
  file.durable = file.bytes;
  file.unsynced.clear();
  return absl::OkStatus();
}

void SimulatedDisk::restore_power() {
  used_ = 0;
  for (auto& [path, file] : files_) {
    for (const Contents::Write& write : file->unsynced) {
      // Sectors are written whole: 512 bytes, some of those of one write perhaps and others not.
      const std::uint64_t fate = random_() % 4;
      if (fate == 0) continue;
      const std::size_t size = fate == 1 ? write.bytes.size() / 512 / 2 * 512 : write.bytes.size();
      if (size > 0 || write.bytes.empty()) apply(write, size, file->durable);
    }
    file->unsynced.clear();
    file->bytes = file->durable;
    used_ += file->bytes.size();
  }
  powered_ = true;
  fail_in_ = 0;
}

std::shared_ptr<SimulatedDisk::Contents> SimulatedDisk::find(const std::string& path, bool create) {
  const auto found = files_.find(path);
  if (found != files_.end()) return found->second;
  return create ? files_.emplace(path, std::make_shared<Contents>()).first->second : nullptr;
}

absl::StatusOr<std::unique_ptr<DiskFile>> SimulatedDisk::open(const std::filesystem::path& path,
                                                              bool create) {
  std::shared_ptr<Contents> contents = find(path.string(), create);
  if (contents == nullptr) return absl::NotFoundError(path.string());
  return std::make_unique<SimulatedFile>(*this, std::move(contents));
}

absl::Status SimulatedDisk::remove(const std::filesystem::path& path) {
  if (absl::Status status = operate(); !status.ok()) return status;
  if (const auto found = files_.find(path.string()); found != files_.end()) {
    used_ -= std::min<std::uint64_t>(used_, found->second->bytes.size());
    files_.erase(found);
  }
  return absl::OkStatus();
}

absl::Status SimulatedDisk::move(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (absl::Status status = remove(to); !status.ok()) return status;
  if (auto node = files_.extract(from.string()); !node.empty()) {
    node.key() = to.string();
    files_.insert(std::move(node));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> SimulatedDisk::list(const std::filesystem::path& directory) {
  std::vector<std::string> names;
  for (const auto& [path, contents] : files_) {
    const std::filesystem::path file(path);
    if (file.parent_path() == directory) names.push_back(file.filename().string());
  }
  return names;
}

absl::Status SimulatedDisk::sync_directory(const std::filesystem::path&) { return operate(); }

std::string SimulatedDisk::sqlite_vfs() const { return kVfsName; }

}  // namespace tessera::server
