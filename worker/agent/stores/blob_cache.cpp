#include "agent/stores/blob_cache.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "wire/digest.h"

namespace tessera::agent {
namespace fs = std::filesystem;
namespace {

// A scene's blobs are asked for a few times while it loads: they are not read and digested each time.
constexpr std::chrono::minutes kTrustInFiles{5};

/// Opens the part of a download for this caller alone. The file may have been renamed or removed by whoever
/// held the lock before: then the name is looked up again.
absl::StatusOr<OpenFile> open_locked(const fs::path& path) {
  while (true) {
    OpenFile file{::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)};
    if (!file.is_open()) return file_error("open", path);
    while (::flock(file.get(), LOCK_EX) != 0) {
      if (errno != EINTR) return file_error("lock", path);
    }
    struct stat locked {};
    struct stat named {};
    if (::fstat(file.get(), &locked) != 0) return file_error("examine", path);
    if (::stat(path.c_str(), &named) == 0 && named.st_ino == locked.st_ino && named.st_dev == locked.st_dev)
      return file;
  }
}

absl::Status append(const OpenFile& file, std::string_view bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return file_error("write", path);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return absl::OkStatus();
}

/// Digests what an interrupted download left behind, and leaves the file position at its end. Returns its
/// length.
absl::StatusOr<std::uint64_t> digest_existing(const OpenFile& file, wire::Sha256& digest,
                                              const fs::path& path) {
  std::vector<char> buffer(std::size_t{1} << 18);
  std::uint64_t length = 0;
  while (true) {
    const ssize_t got = ::read(file.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return file_error("read", path);
    if (got == 0) return length;
    digest.update({buffer.data(), static_cast<std::size_t>(got)});
    length += static_cast<std::uint64_t>(got);
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<BlobCache>> BlobCache::open(base::Clock& clock, fs::path dir,
                                                           std::uint64_t cap_bytes) {
  std::error_code error;
  fs::create_directories(dir / "partial", error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat("blob cache: cannot create ", dir.string(), ": ", error.message()));
  }
  std::unique_ptr<BlobCache> cache{new BlobCache{clock, std::move(dir), cap_bytes}};
  cache->prune("");
  return cache;
}

BlobCache::BlobCache(base::Clock& clock, fs::path dir, std::uint64_t cap_bytes)
    : clock_(clock), dir_(std::move(dir)), cap_bytes_(cap_bytes) {}

class BlobCache::Turn {
 public:
  Turn(BlobCache& cache, const std::string& digest) : cache_(cache), digest_(digest) {
    std::unique_lock lock{cache_.turns_mutex_};
    cache_.turn_ended_.wait(lock, [&] { return cache_.turns_.insert(digest_).second; });
  }
  ~Turn() {
    const std::lock_guard lock{cache_.turns_mutex_};
    cache_.turns_.erase(digest_);
    cache_.turn_ended_.notify_all();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  BlobCache& cache_;
  const std::string& digest_;
};

fs::path BlobCache::blob_path(const std::string& digest) const { return dir_ / digest.substr(0, 2) / digest; }
fs::path BlobCache::partial_path(const std::string& digest) const { return dir_ / "partial" / digest; }

absl::StatusOr<std::optional<render::BlobBytes>> BlobCache::find(const std::string& digest) {
  if (!wire::is_digest(digest))
    return absl::InvalidArgumentError(absl::StrCat("not a blob digest: '", digest, "'"));
  const fs::path path = blob_path(digest);
  const OpenFile file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (!file.is_open()) {
    if (errno == ENOENT) return std::optional<render::BlobBytes>{};
    return file_error("open", path);
  }
  const absl::StatusOr<bool> intact = is_intact(file, digest);
  if (!intact.ok()) return intact.status();
  if (!*intact) {
    spdlog::warn("blob cache: {} is damaged; the blob is fetched again", path.string());
    ::unlink(path.c_str());
    return std::optional<render::BlobBytes>{};
  }
  ::futimens(file.get(), nullptr);  // marks it as used now; on a read-only cache this fails and does no harm
  absl::StatusOr<render::BlobBytes> bytes = map_file(file, path);
  if (!bytes.ok()) return bytes.status();
  return std::optional{*std::move(bytes)};
}

/// Reads the file, not a mapping of it: an error of the disk is then an error, and not the end of the
/// process.
absl::StatusOr<bool> BlobCache::is_intact(const OpenFile& file, const std::string& digest) {
  struct stat info {};
  {
    const std::lock_guard lock{checked_mutex_};
    const auto known = checked_.find(digest);
    if (known != checked_.end() && ::fstat(file.get(), &info) == 0 && known->second.inode == info.st_ino &&
        clock_.now() - known->second.when < kTrustInFiles) {
      return true;
    }
  }
  wire::Sha256 sha;
  const absl::StatusOr<std::uint64_t> length = digest_existing(file, sha, blob_path(digest));
  if (absl::IsDataLoss(length.status())) return false;
  if (!length.ok()) return length.status();
  if (sha.finish_hex() != digest) return false;
  note_checked(file, digest);
  return true;
}

void BlobCache::note_checked(const OpenFile& file, const std::string& digest) {
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return;
  const std::lock_guard lock{checked_mutex_};
  checked_[digest] = {info.st_ino, clock_.now()};
}

absl::StatusOr<render::BlobBytes> BlobCache::get(const std::string& digest, const Fetch& fetch) {
  absl::StatusOr<std::optional<render::BlobBytes>> found = find(digest);
  if (!found.ok()) return found.status();
  if (found->has_value()) return **std::move(found);

  const Turn turn{*this, digest};
  const fs::path part = partial_path(digest);
  absl::StatusOr<OpenFile> file = open_locked(part);
  if (!file.ok()) return file.status();
  // Somebody else may have finished it while this caller waited for the lock.
  found = find(digest);
  if (!found.ok()) return found.status();
  if (found->has_value()) {
    ::unlink(part.c_str());
    return **std::move(found);
  }

  wire::Sha256 sha;
  absl::StatusOr<std::uint64_t> length = digest_existing(*file, sha, part);
  if (!length.ok()) return length.status();
  const absl::Status fetched = fetch(*length, [&](std::string_view chunk) {
    sha.update(chunk);
    return append(*file, chunk, part);
  });
  if (!fetched.ok()) return fetched;  // the part stays, for the next attempt

  if (const std::string actual = sha.finish_hex(); actual != digest) {
    ::unlink(part.c_str());
    return absl::DataLossError(absl::StrCat("blob ", digest, " came with the digest ", actual));
  }
  const fs::path path = blob_path(digest);
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (::fdatasync(file->get()) != 0 || ::rename(part.c_str(), path.c_str()) != 0)
    return file_error("store", path);
  note_checked(*file, digest);
  prune(digest);
  return map_file(*file, path);
}

void BlobCache::drop(const std::string& digest) {
  std::error_code error;  // another worker may have pruned it
  fs::remove(blob_path(digest), error);
}

void BlobCache::prune(const std::string& keep) {
  struct Stored {
    fs::path path;
    fs::file_time_type used;
    std::uint64_t bytes;
  };
  std::lock_guard lock{prune_mutex_};
  std::vector<Stored> stored;
  std::uint64_t total = 0;
  std::error_code error;  // files may vanish under our eyes: another worker prunes the same directory
  for (fs::recursive_directory_iterator it{dir_, error}, end; !error && it != end; it.increment(error)) {
    std::error_code file_gone;
    if (!it->is_regular_file(file_gone) || !wire::is_digest(it->path().filename().string())) continue;
    Stored blob{it->path(), it->last_write_time(file_gone), it->file_size(file_gone)};
    if (file_gone) continue;
    total += blob.bytes;
    if (it->path().filename() != keep && it->path().parent_path().filename() != "partial") {
      stored.push_back(std::move(blob));
    }
  }
  bytes_ = total;
  if (total <= cap_bytes_) return;
  std::sort(stored.begin(), stored.end(), [](const Stored& a, const Stored& b) { return a.used < b.used; });
  for (const Stored& blob : stored) {
    if (total <= cap_bytes_) break;
    // Who has the blob mapped keeps its bytes.
    if (fs::remove(blob.path, error)) total -= blob.bytes;
  }
  bytes_ = total;
}

fs::path default_cache_dir() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return fs::path{cache} / "tessera";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return fs::path{home} / ".cache" / "tessera";
  }
  return fs::temp_directory_path() / absl::StrCat("tessera-", ::getuid());
}

}  // namespace tessera::agent
