#include "wire/phases/irradiance_records.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "wire/phases/blob_arrays.h"
#include "wire/phases/glossy_records.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

namespace {

/// Header of a blob.
struct IrradianceHeader {
  char magic[4] = {'T', 'I', 'R', '1'};
  std::uint32_t record_bytes = sizeof(IrradianceRecord);
  std::uint64_t count = 0;
};
static_assert(sizeof(IrradianceRecord) % sizeof(float) == 0 &&
              std::is_trivially_copyable_v<IrradianceRecord>);

std::uint64_t most_record_bytes(const PhaseBlob& blob) {
  return sizeof(IrradianceHeader) + kGlossyHeaderBytes + blob.part_count() * 2 * kMostRecordBytes;
}

const char* record_fault(std::string_view bytes, const PhaseBlob& blob) {
  std::string_view even, glossy;
  if (!take_record_bytes(bytes, even)) return "no records of an irradiance cache";
  if (even.size() > blob.part_count() * kMostRecordBytes) return "more records than its parts have room for";
  if (bands_of(bytes) != static_cast<int>(blob.glossy_bands))
    return "records of other bands than the job asks for";
  if (!read_glossy_records(bytes, static_cast<int>(blob.glossy_bands)))
    return "no records of glossy surfaces behind the others";
  return nullptr;
}

}  // namespace

bool are_usual(const float* numbers, std::size_t count) {
  return std::all_of(numbers, numbers + count,
                     [](float x) { return std::isfinite(x) && std::abs(x) < 1e18f; });
}

bool is_sound_site(const RecordSite& site) {
  float numbers[sizeof(site) / sizeof(float)];
  std::memcpy(numbers, &site, sizeof(site));
  const float* const n = site.n;
  return are_usual(numbers, std::size(numbers)) &&
         std::abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-3f && site.radius > 0 && site.pixel >= 0;
}

bool is_sound_record(const IrradianceRecord& record) {
  float numbers[sizeof(record) / sizeof(float)];
  std::memcpy(numbers, &record, sizeof(record));
  return are_usual(numbers, std::size(numbers)) && is_sound_site(record) &&
         std::all_of(std::begin(record.irradiance), std::end(record.irradiance),
                     [](float x) { return x >= 0; });
}

std::string blob_of(std::span<const IrradianceRecord> records) {
  IrradianceHeader header;
  header.count = records.size();
  std::string blob(sizeof(header) + records.size_bytes(), '\0');
  std::memcpy(blob.data(), &header, sizeof(header));
  if (!records.empty()) std::memcpy(blob.data() + sizeof(header), records.data(), records.size_bytes());
  return blob;
}

bool take_record_bytes(std::string_view& blob, std::string_view& records) {
  IrradianceHeader header;
  const IrradianceHeader expected;
  if (blob.size() < sizeof(header)) return false;
  std::memcpy(&header, blob.data(), sizeof(header));
  const std::string_view rest = blob.substr(sizeof(header));
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
      header.record_bytes != expected.record_bytes || header.count > rest.size() / sizeof(IrradianceRecord))
    return false;
  records = rest.substr(0, header.count * sizeof(IrradianceRecord));
  if (!all_in_bytes<IrradianceRecord>(records, is_sound_record)) return false;
  blob = rest.substr(records.size());
  return true;
}

bool take_records(std::string_view& blob, std::vector<IrradianceRecord>& records) {
  std::string_view bytes;
  if (!take_record_bytes(blob, bytes)) return false;
  append_values(bytes, records);
  return true;
}

bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records) {
  std::string_view bytes;
  if (!take_record_bytes(blob, bytes) || !blob.empty()) return false;
  append_values(bytes, records);
  return true;
}

const PhaseBlobCheck kIrradianceRecordsCheck{most_record_bytes, record_fault};

}  // namespace tessera::wire
