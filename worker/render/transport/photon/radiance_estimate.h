// Radiance from the photons near a surface point [Jensen 1996].
#pragma once

#include "render/transport/photon_map/photon.h"
#include "render/transport/photon_map/photon_map.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

using RadianceMap = PhotonMap<PhotonFields>;

/// One photon of each estimate, drawn with a probability in proportion to the light that it brings.
struct DrawnPhoton {
  UInt random;  // given: decides which
  // Undefined where the estimate is black.
  Vec3 position = {};
  Vec3 direction = {};  // points to where it came from
  Float way = {};       // distance to there
};

/// The radiance that leaves the vertices along wo, of all photons within `radius`, for which the map was
/// built, that were scattered less than `depth_end` times. Adds it to `layers` too, unless that is null.
/// `dispersed`: of the paths there, PathFields::dispersed, null in scenes without dispersion.
Spectrum radiance_estimate(const RadianceMap& map, const Vertex& v, float radius, int depth_end,
                           const Int* dispersed, Mask active, GatheredLayers* layers, DrawnPhoton& drawn);

}  // namespace tessera::render::TESSERA_ISA
