// A disk whose power can fail at any write, and which can be full.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "store/disk.h"

namespace tessera::server {

/// Files in memory, for the journal's result files and for SQLite alike. What was written and not yet synced
/// may be lost when the power fails: each such write survives whole, in part, or not at all, independently of
/// the others, as on a drive with a cache. After a failure every operation is an error until `restore_power`.
/// One at a time may exist.
class SimulatedDisk final : public Disk {
 public:
  explicit SimulatedDisk(std::uint64_t seed);
  ~SimulatedDisk() override;

  /// The power fails in the middle of the write or sync that comes after so many others; 0: never.
  void fail_power_after(std::uint64_t operations) { fail_in_ = operations; }
  /// Bytes of all files together; beyond them writes are refused.
  void set_capacity(std::uint64_t bytes) { capacity_ = bytes; }
  bool powered() const { return powered_; }
  /// Pulls the plug now, if it is not pulled already, and turns the machine on again: what had not been
  /// synced has been decided upon. Files must have been closed.
  void restore_power();

  absl::StatusOr<std::unique_ptr<DiskFile>> open(const std::filesystem::path& path, bool create) override;
  absl::Status remove(const std::filesystem::path& path) override;
  absl::Status move(const std::filesystem::path& from, const std::filesystem::path& to) override;
  absl::StatusOr<std::vector<std::string>> list(const std::filesystem::path& directory) override;
  absl::Status sync_directory(const std::filesystem::path& directory) override;
  std::string sqlite_vfs() const override;

  /// One file: what the next reader sees, and what is safe.
  struct Contents {
    std::string bytes;
    std::string durable;
    struct Write {
      std::uint64_t offset = 0;
      std::string bytes;  // empty: cut to `offset`
    };
    std::vector<Write> unsynced;
  };

  // ---- what both kinds of files are made of
  absl::Status write(Contents& file, std::uint64_t offset, std::string_view bytes);
  absl::Status truncate(Contents& file, std::uint64_t size);
  absl::Status sync(Contents& file);
  std::shared_ptr<Contents> find(const std::string& path, bool create);

 private:
  /// Counts one operation; an error when it is the one in which the power fails, or after that.
  absl::Status operate();

  std::mt19937_64 random_;
  std::map<std::string, std::shared_ptr<Contents>> files_;
  std::uint64_t fail_in_ = 0;
  std::uint64_t capacity_ = std::uint64_t{1} << 40;
  std::uint64_t used_ = 0;
  bool powered_ = true;
};

}  // namespace tessera::server
