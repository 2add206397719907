#include "store/sqlite/checked_pages.h"

#include <cstdint>
#include <cstring>
#include <new>
#include <string>

#include "store/log/checksum.h"

namespace tessera::server {
namespace {

constexpr char kName[] = "tessera-checked";
constexpr int kSumBytes = 8;
constexpr int kSmallestPage = 512;
constexpr int kReservedAt =
    20;  // byte of the database's header: how many bytes of each page are not SQLite's

/// SQLite's file, and behind it in memory the machine's own.
struct CheckedFile {
  sqlite3_file base;
  bool database;  // not a log, nor anything temporary
  bool has_sums;  // its header says so
};

sqlite3_file* machine_file(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<CheckedFile*>(file) + 1);
}
sqlite3_vfs* machine_vfs(sqlite3_vfs* vfs) { return static_cast<sqlite3_vfs*>(vfs->pAppData); }

/// Checksum of a page without the sum at its end, and of its place.
std::uint64_t sum_of(const char* page, int size, sqlite3_int64 offset) {
  return checksum({page, static_cast<std::size_t>(size - kSumBytes)}, static_cast<std::uint64_t>(offset));
}

bool is_page(int size, sqlite3_int64 offset) {
  return size >= kSmallestPage && (size & (size - 1)) == 0 && offset % size == 0;
}

void look_at_header(CheckedFile& file, const char* bytes, int size, sqlite3_int64 offset) {
  if (offset == 0 && size > kReservedAt) file.has_sums = bytes[kReservedAt] == kSumBytes;
}

/// A page that was never written is a hole, all zeros.
bool is_intact(const char* page, int size, sqlite3_int64 offset) {
  std::uint64_t sum;
  std::memcpy(&sum, page + size - kSumBytes, sizeof(sum));
  if (sum == sum_of(page, size, offset)) return true;
  for (int i = 0; i < size; ++i) {
    if (page[i] != 0) return false;
  }
  return true;
}

/// The header says that there are no sums, but its own page has one: what is damaged is the header.
bool has_lost_its_mark(const char* page, int size, sqlite3_int64 offset) {
  if (offset != 0) return false;
  std::string marked(page, static_cast<std::size_t>(size));
  marked[kReservedAt] = kSumBytes;
  std::uint64_t sum;
  std::memcpy(&sum, page + size - kSumBytes, sizeof(sum));
  return sum == sum_of(marked.data(), size, offset);
}

int checked_read(sqlite3_file* file, void* out, int size, sqlite3_int64 offset) {
  const int code = machine_file(file)->pMethods->xRead(machine_file(file), out, size, offset);
  auto& checked = *reinterpret_cast<CheckedFile*>(file);
  if (code != SQLITE_OK || !checked.database) return code;
  const char* const bytes = static_cast<const char*>(out);
  look_at_header(checked, bytes, size, offset);
  if (!is_page(size, offset)) return SQLITE_OK;
  const bool intact =
      checked.has_sums ? is_intact(bytes, size, offset) : !has_lost_its_mark(bytes, size, offset);
  return intact ? SQLITE_OK : SQLITE_IOERR_DATA;
}

int checked_write(sqlite3_file* file, const void* in, int size, sqlite3_int64 offset) {
  auto& checked = *reinterpret_cast<CheckedFile*>(file);
  sqlite3_file* const machine = machine_file(file);
  const char* const bytes = static_cast<const char*>(in);
  if (checked.database) look_at_header(checked, bytes, size, offset);
  if (!checked.database || !checked.has_sums || !is_page(size, offset)) {
    return machine->pMethods->xWrite(machine, in, size, offset);
  }
  // The page belongs to SQLite's cache, so a copy gets the sum.
  std::string page(bytes, static_cast<std::size_t>(size));
  const std::uint64_t sum = sum_of(bytes, size, offset);
  std::memcpy(page.data() + size - kSumBytes, &sum, sizeof(sum));
  return machine->pMethods->xWrite(machine, page.data(), size, offset);
}

// The rest is the machine's.
int pass_close(sqlite3_file* file) { return machine_file(file)->pMethods->xClose(machine_file(file)); }
int pass_truncate(sqlite3_file* file, sqlite3_int64 size) {
  return machine_file(file)->pMethods->xTruncate(machine_file(file), size);
}
int pass_sync(sqlite3_file* file, int flags) {
  return machine_file(file)->pMethods->xSync(machine_file(file), flags);
}
int pass_size(sqlite3_file* file, sqlite3_int64* size) {
  return machine_file(file)->pMethods->xFileSize(machine_file(file), size);
}
int pass_lock(sqlite3_file* file, int lock) {
  return machine_file(file)->pMethods->xLock(machine_file(file), lock);
}
int pass_unlock(sqlite3_file* file, int lock) {
  return machine_file(file)->pMethods->xUnlock(machine_file(file), lock);
}
int pass_check_lock(sqlite3_file* file, int* locked) {
  return machine_file(file)->pMethods->xCheckReservedLock(machine_file(file), locked);
}
int pass_control(sqlite3_file* file, int operation, void* argument) {
  return machine_file(file)->pMethods->xFileControl(machine_file(file), operation, argument);
}
int pass_sector_size(sqlite3_file* file) {
  return machine_file(file)->pMethods->xSectorSize(machine_file(file));
}
int pass_characteristics(sqlite3_file* file) {
  return machine_file(file)->pMethods->xDeviceCharacteristics(machine_file(file));
}

sqlite3_io_methods checked_methods() {
  sqlite3_io_methods methods{};
  methods.iVersion =
      1;  // neither shared memory (the journal is one process's alone) nor mapping, which would pass by
  methods.xClose = pass_close, methods.xRead = checked_read, methods.xWrite = checked_write;
  methods.xTruncate = pass_truncate, methods.xSync = pass_sync, methods.xFileSize = pass_size;
  methods.xLock = pass_lock, methods.xUnlock = pass_unlock, methods.xCheckReservedLock = pass_check_lock;
  methods.xFileControl = pass_control, methods.xSectorSize = pass_sector_size;
  methods.xDeviceCharacteristics = pass_characteristics;
  return methods;
}

int checked_open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  static const sqlite3_io_methods methods = checked_methods();
  auto& checked = *reinterpret_cast<CheckedFile*>(file);
  checked.base.pMethods = nullptr;
  checked.database = (flags & SQLITE_OPEN_MAIN_DB) != 0;
  checked.has_sums = false;
  const int code = machine_vfs(vfs)->xOpen(machine_vfs(vfs), name, machine_file(file), flags, out_flags);
  if (machine_file(file)->pMethods != nullptr) checked.base.pMethods = &methods;  // that it be closed
  return code;
}

int pass_delete(sqlite3_vfs* vfs, const char* name, int sync) {
  return machine_vfs(vfs)->xDelete(machine_vfs(vfs), name, sync);
}
int pass_access(sqlite3_vfs* vfs, const char* name, int flags, int* found) {
  return machine_vfs(vfs)->xAccess(machine_vfs(vfs), name, flags, found);
}
int pass_full_path(sqlite3_vfs* vfs, const char* name, int size, char* out) {
  return machine_vfs(vfs)->xFullPathname(machine_vfs(vfs), name, size, out);
}
int pass_randomness(sqlite3_vfs* vfs, int size, char* out) {
  return machine_vfs(vfs)->xRandomness(machine_vfs(vfs), size, out);
}
int pass_sleep(sqlite3_vfs* vfs, int microseconds) {
  return machine_vfs(vfs)->xSleep(machine_vfs(vfs), microseconds);
}
int pass_time(sqlite3_vfs* vfs, double* now) { return machine_vfs(vfs)->xCurrentTime(machine_vfs(vfs), now); }
int pass_last_error(sqlite3_vfs* vfs, int size, char* out) {
  return machine_vfs(vfs)->xGetLastError(machine_vfs(vfs), size, out);
}

sqlite3_vfs make_vfs() {
  sqlite3_vfs* const machine = sqlite3_vfs_find(nullptr);
  sqlite3_vfs vfs{};
  vfs.iVersion = 1;
  vfs.szOsFile = static_cast<int>(sizeof(CheckedFile)) + machine->szOsFile;
  vfs.mxPathname = machine->mxPathname, vfs.zName = kName, vfs.pAppData = machine;
  vfs.xOpen = checked_open, vfs.xDelete = pass_delete, vfs.xAccess = pass_access,
  vfs.xFullPathname = pass_full_path;
  vfs.xRandomness = pass_randomness, vfs.xSleep = pass_sleep, vfs.xCurrentTime = pass_time;
  vfs.xGetLastError = pass_last_error;
  return vfs;
}

}  // namespace

const char* checked_pages_vfs() {
  static sqlite3_vfs vfs = make_vfs();
  static const int registered = sqlite3_vfs_register(&vfs, /*makeDflt=*/0);
  if (registered != SQLITE_OK) throw std::bad_alloc();
  return kName;
}

int make_room_for_checksums(sqlite3* database) {
  int reserved = kSumBytes;  // becomes what it was
  const int code = sqlite3_file_control(database, "main", SQLITE_FCNTL_RESERVE_BYTES, &reserved);
  if (code != SQLITE_OK || reserved == kSumBytes) return code;
  return sqlite3_exec(database, "VACUUM", nullptr, nullptr, nullptr);
}

}  // namespace tessera::server
