// Incoming radiance at points of glossy surfaces, and how it changes around them: records of an irradiance
// cache.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "wire/phases/irradiance_records.h"

namespace tessera::wire {

/// The number of spherical harmonics over a hemisphere in so many bands: l + 1 in band l.
constexpr int count_of_harmonics(int bands) { return bands * (bands + 1) / 2; }

/// Records with the light that other surfaces bring, by direction: the coefficients of hemispherical
/// harmonics in the frame of the normal, and their change along that frame's x and y, a unit of length
/// [Krivanek, Gautron, Pattanaik & Bouatouch 2005]. Lamps that shine on the point themselves are not in it.
struct GlossyRecords {
  /// Numbers of one coefficient: value, change along x and along y, each with all bands of colour.
  static constexpr std::size_t kOfCoefficient = 3 * kRecordBands;

  int bands = 0;  // bands of the harmonics; 0: there are no records
  std::vector<RecordSite> sites;
  std::vector<float> numbers;  // all coefficients of a site, then those of the next

  std::size_t stride() const { return static_cast<std::size_t>(count_of_harmonics(bands)) * kOfCoefficient; }
  std::size_t record_bytes() const { return sizeof(RecordSite) + stride() * sizeof(float); }
  std::span<const float> numbers_of(std::size_t i) const {
    return std::span(numbers).subspan(i * stride(), stride());
  }
};

/// Takes the last record back where lookups could not trust its numbers: blobs have no such ones.
void take_back_unsound(GlossyRecords& records);

/// The bytes of a blob, and what is in it: nothing else gives the same.
std::string blob_of(const GlossyRecords& records);
inline constexpr std::size_t kGlossyHeaderBytes = 16;
/// Arrays of a blob.
struct GlossyBytes {
  std::string_view sites, numbers;
};
/// Absent where the blob is none of records with so many bands, and nothing else: damaged, of another length,
/// or with numbers that no record has.
std::optional<GlossyBytes> read_glossy_records(std::string_view blob, int bands);
/// Appends the records of a blob, which has as many bands. False, and nothing appended, where it is none.
bool append_records(std::string_view blob, GlossyRecords& records);
/// The bands that a blob says its records have; -1 where it is too short, or no records have so many.
int bands_of(std::string_view blob);

}  // namespace tessera::wire
