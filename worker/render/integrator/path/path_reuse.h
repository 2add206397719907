// Light that neighbouring paths share [Bekaert, Sbert & Halton 2002]: the second surface of a path is joined
// to the first surfaces of its neighbours, and all of them have the light that it sends back. Of all ways to
// find one point the balance heuristic makes one estimate [Veach 1997, section 9.2.2], so each sample is as
// unbiased as it would be alone, and no pair of surfaces weighs more than what one of them would find by
// itself.
//
// A second surface that scatters evenly shares all that its path finds from there on. Another one shares the
// light of its sample of a light, what its path meets next and emits, and what is sent back there: its BSDF
// is evaluated towards each neighbour, and the heuristic goes over the direction as well. A lamp or the sky
// may be found by either sample, so both densities count. Parts are told apart by where light comes from;
// each has one set of estimators.
#pragma once

#include <cstdint>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/integrator/sample_batch.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class PathReuse {
 public:
  /// `group` neighbours share: samples of a batch from 0 on, 2, 4, 8 or 16. Not for scenes with media,
  /// motion, opacity, layers of light or lamps with interpolated normals.
  PathReuse(const IntegratorContext& context, int group);

  /// A batch of `n` paths has found the first surfaces, then, of those that go on, the second ones.
  void begin(const PathState& paths, const HitState& hits, int n);
  void keep_second(const PathState& paths, const HitState& hits, int n);
  /// First, second and third surfaces are shaded, at `v`, and what they emit is in the sample's radiance.
  /// What is shared of the paths that are left is computed for a throughput of 1.
  void at_first(const Vertex& v, Int slot, Mask hit);
  void at_second(const Vertex& v, WidePath& path, Mask hit, SampleBatch& batch);
  void at_third(WidePath& path, Mask hit, SampleBatch& batch);
  /// Lanes whose second surface shares the light that was sampled along `wi`, with density `pdf`: what is
  /// sent to it is neither scattered there nor weighed.
  Mask share_light(Int slot, Vec3 wi, Float pdf, Mask delta, Mask lanes, SampleBatch& batch);
  /// Lanes whose second surface shares what comes from a lamp or the sky that the path has met, which samples
  /// of lights find with density `by_lights`: it is not the sample's own.
  Mask share_emission(const WidePath& path, Spectrum radiance, Float by_lights, Mask lanes);
  /// Sampled light has come.
  void lights_traced(SampleBatch& batch);
  /// The paths have ended: hands out what is shared. `queue` is empty, before and after.
  void finish(SampleBatch& batch, ConnectionQueue& queue);

 private:
  /// What the second surface of a sample shares.
  enum Shared : std::int32_t {
    kEven = 1,    // all
    kGlossy = 2,  // or some of what follows:
    kLight = 4,   // light of a sampled light ...
    kDelta = 8,   // ... which nothing else finds
    kFound = 16,  // what the third surface, or the sky, emits
    kBeyond = 32  // what the third surface sends back
  };

  /// Values of pairs of samples i and i ^ step, at pair(step, i).
  using Pairs = std::vector<float>;
  struct SpectrumPairs {
    Pairs c[kSpectrumLanes];
  };

  std::size_t pair(int step, int i) const { return static_cast<std::size_t>(step * kPadded + i); }
  Float load(const Pairs& pairs, int step, Int sample) const {
    return gather(pairs.data(), sample + step * kPadded);
  }
  void set_apart(Int slot, Mask lanes, SampleBatch& batch);
  /// Vertices of 16 samples from `first` on, event 0 or 1 of their paths.
  Vertex vertex_at(const Vec3Lanes& origin, const Vec3Lanes& direction, const HitState& hits, int event,
                   int first, const SampleBatch& batch, Mask lanes) const;
  void collect(int first, SampleBatch& batch);
  void join(int first, const SampleBatch& batch, ConnectionQueue& queue);
  void scatter_back(int first, const Vertex& second, const Vec3Lanes& wi, Int which, SpectrumPairs& value,
                    Pairs& pdf) const;
  Float density_along(int first, Mask lanes, const SpectrumPairs& value, const Pairs& pdf) const;
  void trace(ConnectionQueue& queue);
  void hand_out(int first, SampleBatch& batch) const;

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const int group_;
  int size_ = 0;
  bool any_shared_ = false;
  // By samples: rays to first and second surfaces and what they hit
  Vec3Lanes origin_[2], direction_[2];
  HitState hits_[2];
  Vec3Lanes first_;        // points of first surfaces
  Vec3Lanes p_, ng_, ns_;  // second surfaces, seen from where the path came
  Lanes<float> error_;
  alignas(64) Lanes<std::int32_t> shared_;  // bits of Shared
  Vec3Lanes to_light_, on_;                 // to the sampled light, and in which the path went
  SpectrumLanes own_;                       // radiance that is the sample's alone, as far as it is set apart
  SpectrumLanes light_, found_;             // kLight, kFound: what comes along to_light_ and on_
  alignas(64) Lanes<float> light_pdf_, found_pdf_;  // with which samples of lights find that
  SpectrumLanes suffix_;                            // kEven: what is sent back; kBeyond: what comes along on_
  // Pairs: the first surface of i, the second one of its partner
  Pairs pdf_;             // by area of the second surface; 0: not found from there
  SpectrumPairs weight_;  // of light that is sent back there
  // For directions to_light_ and on_ at the second surface, seen from the first: factors and densities
  SpectrumPairs of_light_, of_on_;
  Pairs pdf_light_, pdf_on_;
};

}  // namespace tessera::render::TESSERA_ISA
