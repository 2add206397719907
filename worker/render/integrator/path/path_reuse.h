// Light that neighbouring paths share [Bekaert, Sbert & Halton 2002]: the second surface of a path is
// joined to the first surfaces of its neighbours, and all of them have the light that it sends back. The
// first one is that behind mirrors and clear glass, which cannot be joined to anything. Of all ways to
// find one point the balance heuristic makes one estimate [Veach 1997, section 9.2.2], so each sample is
// as unbiased as it would be alone, and no pair of surfaces weighs more than what one of them would find
// by itself.
//
// A second surface that scatters evenly shares all that its path finds from there on. Another one shares the
// light of its sample of a light, what its path meets next and emits, and what is sent back there: its BSDF
// is evaluated towards each neighbour, and the heuristic goes over the direction as well. A lamp or the sky
// may be found by either sample, so both densities count. Parts are told apart by where light comes from;
// each has one set of estimators.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/integrator/guide/guide_field.h"
#include "render/integrator/integrator.h"
#include "render/integrator/vertex/path_state.h"
#include "render/integrator/vertex/sample_batch.h"
#include "render/integrator/vertex/transit.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class PathReuse {
 public:
  /// `group` neighbours share: samples of a batch from 0 on, 2, 4, 8 or 16, of one time where things move.
  /// Not for scenes with media, layers of light, or sheets that tint what they let straight through. `room`
  /// is for hits once paths have ended.
  PathReuse(const IntegratorContext& context, int group, const GuideField* guide, Transit& transit,
            HitState& room);

  /// A batch of `n` paths has met its first event.
  void begin(const PathState& paths, const HitState& hits, int n);
  /// Whether at the event of `depth` paths may be at their first, second or third surfaces; if not, nothing
  /// needs to be told of it.
  bool follows(int depth) const { return depth <= std::max(last_first_ + 2, last_mirror_ + 1); }
  /// Paths are shaded at `v`, and what is emitted there is in the samples' radiance; `mix` chose the part of
  /// a mixed material, `guided` is how the paths are guided, if there is a guide. What is shared of the paths
  /// that are left is computed for a throughput of 1.
  void at_surface(const Vertex& v, const Hit& hit, Float mix, const Guided& guided, WidePath& path,
                  Mask lanes, int depth, SampleBatch& batch);
  /// Lanes whose second surface shares the light that was sampled along `wi`, with density `pdf`: what is
  /// sent to it is neither scattered there nor weighed.
  Mask share_light(Int slot, Vec3 wi, Float pdf, Mask delta, Mask lanes, int depth, SampleBatch& batch);
  /// Lanes whose second surface shares what comes from a lamp or the sky that the path has met, which samples
  /// of lights find with density `by_lights`: it is not the sample's own.
  Mask share_emission(const WidePath& path, Spectrum radiance, Float by_lights, Mask lanes, int depth);
  /// Sampled light has come.
  void lights_traced(int depth, SampleBatch& batch);
  /// Lanes that Russian roulette may not end, at a first or a second surface: whether paths go on from there
  /// would be part of the density with which neighbours find what comes next.
  Mask spared(Int slot, Mask lanes, int depth) const;
  /// The paths have ended: hands out what is shared. `queue` is empty, before and after.
  void finish(SampleBatch& batch, ConnectionQueue& queue);

 private:
  /// Bits for what the second surface of a sample shares.
  enum Shared : std::int32_t {
    kEven = 1,    // all
    kGlossy = 2,  // or some of what follows:
    kLight = 4,   // light of a sampled light ...
    kDelta = 8,   // ... which nothing else finds
    kFound = 16,  // what the third surface, or the sky, emits
    kBeyond = 32  // what the third surface sends back
  };

  static TESSERA_INLINE Mask has(Int bits, std::int32_t some) { return (bits & Int(some)) != 0; }

  /// Some of the batch's samples, one after the other.
  struct Samples {
    alignas(64) Lanes<std::int32_t> slot;
    int size = 0;

    void append(Int more, Mask lanes) { size += compress_store(more, lanes, slot + size); }
  };
  /// Sixteen of them.
  struct Packet {
    Int slot;
    Mask lanes;
  };
  /// Values of pairs: the first surface at place i of firsts_ and the second one of its group's `member`, at
  /// pair(member, i).
  using Pairs = std::vector<float>;
  struct SpectrumPairs {
    Pairs c[kSpectrumLanes];
  };

  template <class F>
  static void for_each_packet(const Samples& samples, F&& f);
  std::size_t pair(int member, int place) const { return static_cast<std::size_t>(member * kPadded + place); }
  /// The first member of each sample's group.
  Int group_of(Int slot) const { return slot & Int(-group_); }
  Int seeing_pairs(int member, Int slot, Mask& lanes) const;

  void at_first(const Vertex& v, const Hit& hit, Float mix, const Guided& guided, const WidePath& path,
                Mask lanes, int depth);
  void at_second(const Vertex& v, const Hit& hit, Float mix, WidePath& path, Mask lanes, SampleBatch& batch);
  void at_third(const Vertex& v, WidePath& path, Mask lanes, SampleBatch& batch);
  void keep(int event, const WidePath& path, const Hit& hit, Float mix, Mask lanes);
  void set_apart(Int slot, Mask lanes, SampleBatch& batch);

  void collect(int first, SampleBatch& batch);
  void list_samples();
  Vertex vertex_at(int event, const Packet& samples) const;
  void join(int place, const Packet& firsts, ConnectionQueue& queue);
  void trace(ConnectionQueue& queue);
  void march(ConnectionQueue& queue);
  void see_own(int place, const Packet& firsts);
  void scatter_back(const Packet& seconds);
  void scatter_along(const Vertex& second, Vec3 wo, Vec3 wi, Int pairs, Mask lanes, SpectrumPairs& value,
                     Pairs& pdf) const;
  Float density_along(Int pairs, Mask lanes, const SpectrumPairs& value, const Pairs& pdf) const;
  void weigh(const Packet& seconds);
  void hand_out(int place, const Packet& firsts, SampleBatch& batch) const;

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const int group_;
  const GuideField* const guide_;  // may be null
  Transit& transit_;
  HitState& room_;
  int size_ = 0;
  bool any_shared_ = false;
  int last_first_ = -1, last_mirror_ = -1;  // latest events at which paths have met such surfaces
  // By samples: the event of the first surface, and rays to first and second ones and what they hit
  alignas(64) Lanes<std::int32_t> first_event_;
  Vec3Lanes origin_[2], direction_[2];
  HitState hits_[2];
  Lanes<float> mix_[2];   // with mixed materials
  Lanes<float> time_;     // with motion
  SpectrumLanes before_;  // throughput up to the first surface, where it is not the path's first event
  Vec3Lanes first_;       // points of first surfaces
  alignas(64) Lanes<std::int32_t> density_;  // of the guide, that first surfaces follow; -1: none
  Vec3Lanes p_, ng_, ns_;                    // second surfaces, seen from where the path came
  Lanes<float> error_;
  alignas(64) Lanes<std::int32_t> shared_;  // bits of Shared
  Vec3Lanes to_light_, on_;                 // to the sampled light, and in which the path went
  SpectrumLanes own_;                       // radiance that is the sample's alone, as far as it is set apart
  SpectrumLanes light_, found_;             // kLight, kFound: what comes along to_light_ and on_
  Lanes<float> light_pdf_, found_pdf_;      // with which samples of lights find that
  SpectrumLanes suffix_;                    // kEven: what is sent back; kBeyond: what comes along on_
  Lanes<float> by_light_, by_found_, by_suffix_;  // one over the densities with which the group finds these
  // Samples that take part: with a first surface, with a second one that scatters evenly, with others
  Samples firsts_, evens_, glossies_;
  Lanes<std::int32_t> place_;  // of a sample in firsts_, or -1
  // One for each pair
  Pairs pdf_;             // by area of the second surface; 0: not found from there
  SpectrumPairs weight_;  // of light that is sent back there
  // For directions to_light_ and on_ at the second surface, seen from the first: factors and densities; where
  // pdf_ is not 0
  SpectrumPairs of_light_, of_on_;
  Pairs pdf_light_, pdf_on_;
};

}  // namespace tessera::render::TESSERA_ISA
