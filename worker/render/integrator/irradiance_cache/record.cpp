#include "render/integrator/irradiance_cache/record.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <type_traits>

namespace tessera::render::TESSERA_ISA {

namespace {

/// Header of a blob.
struct Header {
  char magic[4] = {'T', 'I', 'R', '1'};
  std::uint32_t record_bytes = sizeof(IrradianceRecord);
  std::uint64_t count = 0;
};
static_assert(sizeof(IrradianceRecord) % sizeof(float) == 0 &&
              std::is_trivially_copyable_v<IrradianceRecord>);

}  // namespace

bool is_sound_record(const IrradianceRecord& record) {
  float numbers[sizeof(record) / sizeof(float)];
  std::memcpy(numbers, &record, sizeof(record));
  return are_usual(numbers, std::size(numbers)) && is_sound(record) &&
         std::all_of(std::begin(record.irradiance), std::end(record.irradiance),
                     [](float x) { return x >= 0; });
}

std::string blob_of(std::span<const IrradianceRecord> records) {
  Header header;
  header.count = records.size();
  std::string blob(sizeof(header) + records.size_bytes(), '\0');
  std::memcpy(blob.data(), &header, sizeof(header));
  if (!records.empty()) std::memcpy(blob.data() + sizeof(header), records.data(), records.size_bytes());
  return blob;
}

bool take_records(std::string_view& blob, std::vector<IrradianceRecord>& records) {
  Header header;
  const Header expected;
  if (blob.size() < sizeof(header)) return false;
  std::memcpy(&header, blob.data(), sizeof(header));
  std::string_view rest = blob.substr(sizeof(header));
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
      header.record_bytes != expected.record_bytes || header.count > rest.size() / sizeof(IrradianceRecord))
    return false;
  const std::size_t before = records.size(), bytes = header.count * sizeof(IrradianceRecord);
  records.resize(before + header.count);
  if (bytes != 0) std::memcpy(static_cast<void*>(records.data() + before), rest.data(), bytes);
  if (!std::all_of(records.begin() + static_cast<std::ptrdiff_t>(before), records.end(), is_sound_record)) {
    records.resize(before);
    return false;
  }
  blob = rest.substr(bytes);
  return true;
}

bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records) {
  const std::size_t before = records.size();
  if (!take_records(blob, records)) return false;
  if (blob.empty()) return true;
  records.resize(before);
  return false;
}

}  // namespace tessera::render::TESSERA_ISA
