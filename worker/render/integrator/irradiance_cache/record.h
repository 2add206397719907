// Irradiance at a point, and how it changes around it: what the cache is made of.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/color/bands.h"
#include "render/integrator/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

/// Light that other surfaces bring to a point, through the hemisphere around `n` [Ward, Rubinstein & Clear
/// 1988]. Lamps that shine on the point themselves are not in it.
struct IrradianceRecord : RecordSite {
  float irradiance[kBands];
  // Its change with the normal, along the axis about which that turns, a radian; and with the place, a unit
  // of length [Ward & Heckbert 1992].
  float rotation[kBands][3];
  float translation[kBands][3];
};

/// Whether lookups may trust the record's numbers, and its light is not negative: blobs have no others.
bool is_sound_record(const IrradianceRecord& record);

/// The bytes of a blob, and what is in it: nothing else gives the same.
std::string blob_of(std::span<const IrradianceRecord> records);
/// Takes the records from the front of a blob and appends them. False, and nothing appended, where there are
/// none: damaged, too short, or with numbers that no record has.
bool take_records(std::string_view& blob, std::vector<IrradianceRecord>& records);
/// The same for a blob that has nothing else.
bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records);

}  // namespace tessera::render::TESSERA_ISA
