// Incoming radiance at points of glossy surfaces, and how it changes around them.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/color/bands.h"
#include "render/integrator/irradiance_cache/harmonics.h"
#include "render/integrator/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

/// Records with the light that other surfaces bring, by direction: the coefficients of Harmonics in the frame
/// of the normal (Frame::from_normal), and their change along that frame's x and y, a unit of length
/// [Krivanek, Gautron, Pattanaik & Bouatouch 2005]. Lamps that shine on the point themselves are not in it.
struct GlossyRecords {
  /// Numbers of one coefficient: value, change along x and along y, each with all bands of colour.
  static constexpr std::size_t kOfCoefficient = 3 * kBands;

  int bands = 0;  // of the harmonics; 0: there are no records
  std::vector<RecordSite> sites;
  std::vector<float> numbers;  // of all coefficients of a site, then those of the next

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
/// Appends the records of a blob that has no others, and as many bands. False, and nothing appended, where it
/// is none: damaged, of another length, or with numbers that no record has.
bool append_records(std::string_view blob, GlossyRecords& records);
/// The bands that a blob says its records have; -1 where it is too short, or no records have so many.
int bands_of(std::string_view blob);

}  // namespace tessera::render::TESSERA_ISA
