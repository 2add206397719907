// Radiance from the photons near a surface point [Jensen 1996].
#pragma once

#include "render/integrator/photon_map/photon.h"
#include "render/integrator/photon_map/photon_map.h"
#include "render/integrator/vertex/layers.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

using RadianceMap = PhotonMap<PhotonFields>;

/// Directions that a BSDF gives with more than this density (1/sr) are found by sampling it, all others in
/// the map: in a narrow lobe lie few photons. Three times what a diffuse surface has at most. Which way light
/// is found is thereby a matter of two directions alone, and each is found in one way.
inline constexpr float kFocused = 1;

/// Lanes in which the direction `wi` is left to sampling the BSDF.
TESSERA_INLINE Mask is_focused(const BsdfEval& bsdf) { return bsdf.pdf > kFocused; }

/// The radiance that leaves the vertices along wo, of all photons within `radius`, for which the map was
/// built, that were scattered less than `depth_end` times. Adds it to `layers` too, unless that is null.
Spectrum radiance_estimate(const RadianceMap& map, const Vertex& v, float radius, int depth_end, Mask active,
                           GatheredLayers* layers);

}  // namespace tessera::render::TESSERA_ISA
