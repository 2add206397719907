#include "render/integrator/irradiance_cache/glossy_record.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tessera::render::TESSERA_ISA {

namespace {

/// Header of a blob; all sites follow, and then their numbers.
struct GlossyHeader {
  char magic[4] = {'T', 'G', 'R', '1'};
  std::int32_t bands = 0;
  std::uint64_t count = 0;
};
static_assert(std::is_trivially_copyable_v<RecordSite> && sizeof(RecordSite) == 8 * sizeof(float));

template <class T>
void put(const std::vector<T>& items, std::string& blob) {
  if (!items.empty()) blob.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
}

/// Appends `count` items from the front of `bytes`, which has as many.
template <class T>
void take(std::string_view& bytes, std::size_t count, std::vector<T>& items) {
  const std::size_t before = items.size();
  items.resize(before + count);
  if (count > 0) std::memcpy(items.data() + before, bytes.data(), count * sizeof(T));
  bytes.remove_prefix(count * sizeof(T));
}

bool is_sound_site(const RecordSite& site) {
  float numbers[sizeof(site) / sizeof(float)];
  std::memcpy(numbers, &site, sizeof(site));
  return are_usual(numbers, std::size(numbers)) && is_sound(site);
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
  put(records.sites, blob);
  put(records.numbers, blob);
  return blob;
}

int bands_of(std::string_view blob) {
  GlossyHeader header;
  if (blob.size() < sizeof(header)) return -1;
  std::memcpy(&header, blob.data(), sizeof(header));
  return header.bands >= 0 && header.bands <= Harmonics::kMostBands ? header.bands : -1;
}

bool append_records(std::string_view blob, GlossyRecords& records) {
  GlossyHeader header;
  const GlossyHeader expected;
  if (blob.size() < sizeof(header)) return false;
  std::memcpy(&header, blob.data(), sizeof(header));
  blob.remove_prefix(sizeof(header));
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 || header.bands != records.bands ||
      header.count != blob.size() / records.record_bytes() || blob.size() % records.record_bytes() != 0 ||
      (header.bands == 0 && header.count != 0))
    return false;
  const std::size_t sites = records.sites.size(), numbers = records.numbers.size();
  const auto count = static_cast<std::size_t>(header.count);
  take(blob, count, records.sites);
  take(blob, count * records.stride(), records.numbers);
  if (std::all_of(records.sites.begin() + static_cast<std::ptrdiff_t>(sites), records.sites.end(),
                  is_sound_site) &&
      are_usual(records.numbers.data() + numbers, records.numbers.size() - numbers))
    return true;
  records.sites.resize(sites), records.numbers.resize(numbers);
  return false;
}

}  // namespace tessera::render::TESSERA_ISA
