// Making one record: paths through the cells of a hemisphere, traced like those of the picture.
#pragma once

#include "render/integrator/irradiance_cache/hemisphere.h"
#include "render/integrator/irradiance_cache/irradiance_cache.h"

namespace tessera::render::TESSERA_ISA {

/// A point of a surface that a record is wanted for.
struct RecordPlace {
  float p[3], ng[3];  // and the geometric normal
  float error;        // Surface::error
  float n[3];         // unit, on the side that the light comes from
  float pixel;        // width of a pixel of the film there
  std::uint32_t key;  // of its random numbers
};

class Gather final : private IrradianceCached {
 public:
  /// Paths end at records that are `given`, if any are.
  Gather(const IntegratorContext& context, const IrradianceCache* given);

  IrradianceRecord make_record(const RecordPlace& place);

 private:
  /// Takes the distance of what the first segments met, too.
  Mask settle(WidePath& path, const Vertex& v, Float t, Mask hit, int depth) override;
  void trace_cells(const RecordPlace& place, int first, int n);

  Hemisphere hemisphere_;
  alignas(64) Lanes<float> distance_;  // of the samples in flight
};

}  // namespace tessera::render::TESSERA_ISA
