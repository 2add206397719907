#include "wire/phases/glossy_records.h"

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "wire/limits.h"
#include "wire/phases/blob_arrays.h"

namespace tessera::wire {

namespace {

/// Header of a blob; all sites follow, and then their numbers.
struct GlossyHeader {
  char magic[4] = {'T', 'G', 'R', '1'};
  std::int32_t bands = 0;
  std::uint64_t count = 0;
};
static_assert(sizeof(GlossyHeader) == kGlossyHeaderBytes);
static_assert(std::is_trivially_copyable_v<RecordSite> && sizeof(RecordSite) == 8 * sizeof(float));

template <class T>
void put_values(const std::vector<T>& items, std::string& blob) {
  if (!items.empty()) blob.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
}

}  // namespace

void take_back_unsound(GlossyRecords& records) {
  const std::span<const float> numbers = records.numbers_of(records.sites.size() - 1);
  if (is_sound_site(records.sites.back()) && are_usual(numbers.data(), numbers.size())) return;
  records.sites.pop_back();
  records.numbers.resize(records.sites.size() * records.stride());
}

std::string blob_of(const GlossyRecords& records) {
  GlossyHeader header;
  header.bands = records.bands;
  header.count = records.sites.size();
  std::string blob;
  blob.reserve(sizeof(header) + records.sites.size() * records.record_bytes());
  blob.append(reinterpret_cast<const char*>(&header), sizeof(header));
  put_values(records.sites, blob);
  put_values(records.numbers, blob);
  return blob;
}

int bands_of(std::string_view blob) {
  GlossyHeader header;
  if (blob.size() < sizeof(header)) return -1;
  std::memcpy(&header, blob.data(), sizeof(header));
  return header.bands >= 0 && header.bands <= static_cast<int>(kMostGlossyBands) ? header.bands : -1;
}

std::optional<GlossyBytes> read_glossy_records(std::string_view blob, int bands) {
  GlossyHeader header;
  const GlossyHeader expected;
  if (blob.size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, blob.data(), sizeof(header));
  blob.remove_prefix(sizeof(header));
  GlossyRecords none;
  none.bands = bands;
  const std::size_t record_bytes = none.record_bytes();
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 || header.bands != bands ||
      header.count != blob.size() / record_bytes || blob.size() % record_bytes != 0 ||
      (bands == 0 && header.count != 0))
    return std::nullopt;
  const std::size_t site_bytes = header.count * sizeof(RecordSite);
  const GlossyBytes bytes{blob.substr(0, site_bytes), blob.substr(site_bytes)};
  if (!all_in_bytes<RecordSite>(bytes.sites, is_sound_site) ||
      !all_in_bytes<float>(bytes.numbers, [](float number) { return are_usual(&number, 1); }))
    return std::nullopt;
  return bytes;
}

bool append_records(std::string_view blob, GlossyRecords& records) {
  const std::optional<GlossyBytes> bytes = read_glossy_records(blob, records.bands);
  if (!bytes) return false;
  append_values(bytes->sites, records.sites);
  append_values(bytes->numbers, records.numbers);
  return true;
}

}  // namespace tessera::wire
