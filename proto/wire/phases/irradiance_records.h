// Records of an irradiance cache: of its phases. A blob has those of painted surfaces and, behind them, those
// of glossy ones (glossy_records.h).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::wire {

/// Red, green and blue.
inline constexpr int kRecordBands = 3;

/// Most bytes of a part's records of either kind: where there is no room, paths are followed.
inline constexpr std::size_t kMostRecordBytes = std::size_t{16} << 20;

/// The place where a record stands, and how far from there its light holds.
struct RecordSite {
  float p[3];    // render space
  float n[3];    // unit
  float radius;  // about the distance of what is seen from there
  float pixel;   // width of a pixel of the film there
};

/// Light that other surfaces bring to a point, through the hemisphere around `n` [Ward, Rubinstein & Clear
/// 1988]. Lamps that shine on the point themselves are not in it.
struct IrradianceRecord : RecordSite {
  float irradiance[kRecordBands];
  // Its change with the normal, along the axis about which that turns, a radian; and with the place, a unit
  // of length [Ward & Heckbert 1992].
  float rotation[kRecordBands][3];
  float translation[kRecordBands][3];
};

/// Whether lookups may trust `count` numbers that came with a blob.
bool are_usual(const float* numbers, std::size_t count);
/// Whether the numbers of the site are usual and make one: with a unit normal, and a radius.
bool is_sound_site(const RecordSite& site);
/// Whether lookups may trust the record's numbers, and its light is not negative: blobs have no others.
bool is_sound_record(const IrradianceRecord& record);

/// The bytes of a blob, and what is in it: nothing else gives the same.
std::string blob_of(std::span<const IrradianceRecord> records);
/// Finds the records at the front of a blob, and takes them away there. False where there are none: damaged,
/// too short, or with numbers that no record has.
bool take_record_bytes(std::string_view& blob, std::string_view& records);
/// Takes the records from the front of a blob and appends them. False, and nothing appended, where there are
/// none.
bool take_records(std::string_view& blob, std::vector<IrradianceRecord>& records);
/// The same for a blob that has nothing else.
bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records);

}  // namespace tessera::wire
