#include "render/integrator/irradiance_cache/record.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace tessera::render::TESSERA_ISA {

namespace {

/// What a blob begins with.
struct Header {
  char magic[4] = {'T', 'I', 'R', '1'};
  std::uint32_t record_bytes = sizeof(IrradianceRecord);
  std::uint64_t count = 0;
};
static_assert(sizeof(IrradianceRecord) % sizeof(float) == 0 &&
              std::is_trivially_copyable_v<IrradianceRecord>);

/// Whether lookups may trust the numbers: finite, with a unit normal, and light that is not negative.
bool is_sound(const IrradianceRecord& record) {
  float numbers[sizeof(record) / sizeof(float)];
  std::memcpy(numbers, &record, sizeof(record));
  const auto usual = [](float x) { return std::isfinite(x) && std::abs(x) < 1e18f; };
  if (!std::all_of(std::begin(numbers), std::end(numbers), usual)) return false;
  const float* const n = record.n;
  return std::abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-3f && record.radius > 0 &&
         record.pixel >= 0 &&
         std::all_of(std::begin(record.irradiance), std::end(record.irradiance),
                     [](float x) { return x >= 0; });
}

}  // namespace

std::string blob_of(std::span<const IrradianceRecord> records) {
  Header header;
  header.count = records.size();
  std::string blob(sizeof(header) + records.size_bytes(), '\0');
  std::memcpy(blob.data(), &header, sizeof(header));
  if (!records.empty()) std::memcpy(blob.data() + sizeof(header), records.data(), records.size_bytes());
  return blob;
}

bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records) {
  Header header;
  const Header expected;
  if (blob.size() < sizeof(header)) return false;
  std::memcpy(&header, blob.data(), sizeof(header));
  blob.remove_prefix(sizeof(header));
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
      header.record_bytes != expected.record_bytes || blob.size() % sizeof(IrradianceRecord) != 0 ||
      header.count != blob.size() / sizeof(IrradianceRecord))
    return false;
  const std::size_t before = records.size();
  records.resize(before + blob.size() / sizeof(IrradianceRecord));
  if (!blob.empty()) std::memcpy(records.data() + before, blob.data(), blob.size());
  if (std::all_of(records.begin() + static_cast<std::ptrdiff_t>(before), records.end(), is_sound))
    return true;
  records.resize(before);
  return false;
}

}  // namespace tessera::render::TESSERA_ISA
