// Points at which paths are scattered, on surfaces and in media alike: what all algorithms share that build
// paths.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/integrator/interaction.h"
#include "render/integrator/scene_tables.h"
#include "render/light/light.h"
#include "render/medium/medium.h"
#include "render/shape/surface.h"
#include "render/transport/vertex/passing.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen such points.
struct Vertex {
  Vec3 wo;          // unit, back along the path
  Float time;       // time, the same along the path
  Surface surface;  // surface; in media only its `p` is set
  Interaction at;   // the surface's material included
  // Volumetric scenes only
  Mask in_medium = Mask::none();
  Int medium = Int(-1);  // the one that the path came through; -1: none
};

/// The vertex is within a medium in these lanes, at `p`: nothing to offset from, and a phase function in
/// place of a BSDF.
void put_into_medium(Vec3 p, Mask lanes, Vertex& v);

/// Lanes whose material lets part of the light straight through.
TESSERA_INLINE Mask partly_open(const Vertex& v, Mask hit) { return hit & ((v.at.flags & kHasOpacity) != 0); }
/// Lets paths in these lanes through, as far as `u`, uniform in [0, 1), says so.
void open_surface(const SceneTables& scene, Float u, Mask partly, Vertex& v);

/// Value (with the cosine at surfaces) and density for `wi`, given `wo`, of what scatters there, a BSDF or a
/// phase function; by default for paths that go on.
TESSERA_INLINE BsdfEval eval_scattering(const SceneTables& scene, const Vertex& v, Vec3 wo, Vec3 wi,
                                        Mask active, Transport transport = Transport::kRadiance) {
  BsdfEval result = eval_bsdf(v.at, wo, wi, and_not(active, v.in_medium), transport);
  const Mask in_medium = active & v.in_medium;
  if (none(in_medium)) return result;
  const Float phase = phase_value(scene.media, v.medium, wo, wi, in_medium);
  result.f_cos = select(in_medium, Spectrum(phase), result.f_cos);
  result.pdf = select(in_medium, phase, result.pdf);
  return result;
}
TESSERA_INLINE BsdfEval eval_scattering(const SceneTables& scene, const Vertex& v, Vec3 wi, Mask active) {
  return eval_scattering(scene, v, v.wo, wi, active);
}

/// A direction in which the path goes on.
TESSERA_INLINE BsdfSample sample_scattering(const SceneTables& scene, const Vertex& v, Float u_lobe, Vec2 u,
                                            Mask active, Transport transport = Transport::kRadiance) {
  Mask hit = active;
  if (scene.paths_pass) {
    hit = and_not(active, v.in_medium);
    // Light that passes has been let through before; a sheet reflects what is left: 0 chooses that lobe.
    u_lobe = select((v.at.flags & kPassesStraight) != 0, Float(0.0f), u_lobe);
  }
  BsdfSample result = sample_bsdf(v.at, v.wo, u_lobe, u, hit, transport);
  if (none(v.in_medium)) return result;
  const PhaseSample phase = sample_phase(scene.media, v.medium, v.wo, u, v.in_medium);
  result.wi = select(v.in_medium, phase.wi, result.wi);
  result.weight = select(v.in_medium, Spectrum(1.0f), result.weight);
  result.pdf = select(v.in_medium, phase.pdf, result.pdf);
  result.valid |= v.in_medium;
  result.specular = and_not(result.specular, v.in_medium);
  result.transmission = and_not(result.transmission, v.in_medium);
  return result;
}

/// Lanes whose vertex can be joined to other points: it does not scatter by delta lobes alone.
TESSERA_INLINE Mask joinable(const Vertex& v, Mask active) {
  return active & ((v.at.flags & kAllDelta) == 0);
}

/// The vertex as lights see it.
TESSERA_INLINE Receiver receiver_at(const SceneTables& scene, const Vertex& v) {
  Receiver receiver(v.surface.p);
  receiver.time = v.time;
  if (!scene.lights.uses_normals) return receiver;
  const Mask one_way = and_not(reflects_only(v.at), v.in_medium);
  const Vec3 n = face_forward(v.at.frame.z, v.wo);
  receiver.normal = {select_or_zero(one_way, n.x), select_or_zero(one_way, n.y),
                     select_or_zero(one_way, n.z)};
  return receiver;
}

/// |cos| between `w` and the true surface; 1 in media.
TESSERA_INLINE Float cosine_at(const Vertex& v, Vec3 w) {
  return select(v.in_medium, 1.0f, abs(dot(w, v.surface.ng)));
}

/// A ray from the vertex, offset to the side that `w` points to, up to `target`; what it carries is left
/// open.
TESSERA_INLINE WideConnection connect(const SceneTables& scene, const Vertex& v, Vec3 w, Vec3 target,
                                      Mask active) {
  WideConnection result;
  result.origin = offset_origin(v.surface, w);
  const Vec3 rest = target - result.origin;
  result.distance = length(rest);
  result.direction = rest * (1.0f / max(result.distance, 1e-30f));
  result.time = v.time;
  if (scene.volumetric) {
    result.medium = medium_behind(scene.shapes, v.surface, w, v.medium, and_not(active, v.in_medium));
  }
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
