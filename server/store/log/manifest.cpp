#include "store/log/manifest.h"

#include <string_view>
#include <utility>

#include "store/log/checksum.h"

namespace tessera::server {
namespace {

constexpr std::uint64_t kManifestMagic = 0x31464e4d52535354;  // "TSSRMNF1"
constexpr std::uint64_t kSlotBytes = 512;                     // a sector, which is written whole

struct Slot {
  std::uint64_t magic = kManifestMagic;
  std::uint64_t write = 0;  // the number of this write: the higher one counts
  ManifestCounts counts;
  std::uint64_t checksum = 0;

  std::string_view bytes() const { return {reinterpret_cast<const char*>(this), sizeof(Slot)}; }
  std::uint64_t sum() const {
    Slot unsigned_slot = *this;
    unsigned_slot.checksum = 0;
    return server::checksum(unsigned_slot.bytes(), /*seed=*/0);
  }
};
static_assert(sizeof(Slot) == 72, "has no padding: it is written as it lies in memory");

}  // namespace

absl::StatusOr<Manifest> Manifest::open(Disk& disk, const std::filesystem::path& path) {
  auto file = disk.open(path, /*create=*/true);
  if (!file.ok()) return file.status();
  Manifest manifest(*std::move(file));
  const absl::StatusOr<std::uint64_t> size = manifest.file_->size();
  if (!size.ok()) return size.status();
  for (std::uint64_t i = 0; i < 2; ++i) {
    Slot slot;
    if (*size < i * kSlotBytes + sizeof(slot)) break;
    if (absl::Status status =
            manifest.file_->read_at(i * kSlotBytes, reinterpret_cast<char*>(&slot), sizeof(slot));
        !status.ok()) {
      return status;
    }
    if (slot.magic != kManifestMagic || slot.checksum != slot.sum() || slot.write <= manifest.writes_)
      continue;
    manifest.writes_ = slot.write;
    manifest.found_ = slot.counts;
  }
  return manifest;
}

absl::Status Manifest::write(const ManifestCounts& counts) {
  Slot slot{.write = ++writes_, .counts = counts};
  slot.checksum = slot.sum();
  return file_->write_at(writes_ % 2 * kSlotBytes, slot.bytes());
}

}  // namespace tessera::server
