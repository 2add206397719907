// Making one record: paths through the cells of a hemisphere, traced like those of the picture.
#pragma once

#include <vector>

#include "render/textbook/irradiance_cache/hemisphere.h"
#include "render/textbook/irradiance_cache/irradiance_cache.h"
#include "render/textbook/irradiance_cache/radiance_hemisphere.h"
#include "render/textbook/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

/// A point of a surface that a record is wanted for.
struct RecordPlace {
  float p[3], ng[3];  // place and geometric normal
  float error;        // Surface::error
  float n[3];         // unit, on the side that the light comes from
  float pixel;        // width of a pixel of the film there
  std::uint32_t random_key;
  bool glossy;  // a record of incoming radiance
};

class Gather final : private IrradianceCached {
 public:
  /// Paths end at records that are `given`, if any are.
  Gather(const IntegratorContext& context, const IrradianceCache* given);

  IrradianceRecord make_record(const RecordPlace& place);
  /// Appends a record of incoming radiance.
  void make_record(const RecordPlace& place, GlossyRecords& records);

 private:
  /// Takes the distance of what the first segments met, too.
  void met(Encounter& e) override;
  /// The level of the hemisphere for a record that reaches so far.
  std::size_t level_of(const RecordSite& site) const;
  /// The estimate of a hemisphere of as many cells as the record's reach is worth, and its site.
  template <class H>
  typename H::Estimate look_around(const RecordPlace& place, std::vector<H>& hemispheres, RecordSite& site);
  static void keep(Hemisphere& hemisphere, int first, int n, Vec3, Vec3 light, Float distance);
  static void keep(RadianceHemisphere& hemisphere, int first, int n, Vec3 directions, Vec3 light,
                   Float distance);
  /// Follows paths through all cells of `hemisphere`.
  void trace_cells(const RecordPlace& place, auto& hemisphere);
  void start_paths(const RecordPlace& place, const auto& hemisphere, int first, int n);

  // Ever finer ones.
  std::vector<Hemisphere> hemispheres_;
  std::vector<RadianceHemisphere> glossy_hemispheres_;
  alignas(64) Lanes<float> sample_distance_;    // along first segments
  alignas(64) Lanes<float> cell_direction_[3];  // z: along the normal
};

}  // namespace tessera::render::TESSERA_ISA
