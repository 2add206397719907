// Emitting meshes with vertex normals as Mitsuba 3 renders them.
//
// Mitsuba finds their light in two ways. Points that it samples have the interpolated normal n_s, whose
// cosine stands in for the true normal's in the density of the direction; rays that meet the mesh take the
// radiance as it is. Both see the surface dark where n_s turns away. Its picture is the sum of both, weighed
// by the power heuristic on the densities p_l (of its light sampling, by n_s) and p_b (of the BSDF or phase
// function): radiance times
//     w cos(n_s) / cos(n) + 1 - w,  w = p_l^2 / (p_l^2 + p_b^2).
// That factor is a function of the two points alone, so it is applied here whichever way the light was found.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes whose light is kInterpolated.
Mask has_interpolated_normals(const LightTable& table, Int light, Mask active);

/// The factor of the light that leaves `surface` along `wo`, `distance` away from where it is scattered with
/// density `bsdf_pdf` (solid angle; 0: seen directly or in a mirror). 1 for lights that are not
/// kInterpolated.
Float interpolated_normal_factor(const LightTable& table, Int light, const Surface& surface, Vec3 wo,
                                 Float distance, Float bsdf_pdf, Mask active);

/// The same at the point that `sample` found from `reference`.
Float interpolated_normal_factor(const LightTable& table, Int light, Vec3 reference,
                                 const LightSample& sample, Float bsdf_pdf, Mask active);

}  // namespace tessera::render::TESSERA_ISA
