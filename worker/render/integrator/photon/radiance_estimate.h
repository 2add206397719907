// Radiance from the photons near a surface point [Jensen 1996].
#pragma once

#include "render/integrator/photon_map/photon.h"
#include "render/integrator/photon_map/photon_map.h"
#include "render/integrator/vertex/layers.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

using RadianceMap = PhotonMap<PhotonFields>;

/// The radiance that leaves the vertices along wo, of all photons within `radius`, for which the map was
/// built, that were scattered less than `depth_end` times. Adds it to `layers` too, unless that is null.
Spectrum radiance_estimate(const RadianceMap& map, const Vertex& v, float radius, int depth_end, Mask active,
                           GatheredLayers* layers);

}  // namespace tessera::render::TESSERA_ISA
