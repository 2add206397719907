// Light that neighbouring paths share [Bekaert, Sbert & Halton 2002]: the second surface of a path is
// joined to the first surfaces of its neighbours, and all of them have the light that it sends back. The
// first one is that behind mirrors and clear glass, which cannot be joined to anything. Of all ways to
// find one point the balance heuristic makes one estimate [Veach 1997, section 9.2.2], so each sample is
// as unbiased as it would be alone, and no pair of surfaces weighs more than what one of them would find
// by itself.
//
// Where an index of refraction varies with the wavelength, only paths are joined to one another that have the
// same wavelengths left at their first surfaces: a group's are the same, and so is the first of them. Rough
// glass that disperses is like a mirror, and what follows the second surface may end the others as it likes.
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

#include "render/integrator/integrator.h"
#include "render/transport/vertex/path_observer.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/transit.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class PathReuse final : public PathObserver {
 public:
  /// `group` neighbours share: samples of a batch from 0 on, 2, 4, 8 or 16, of one time where things move.
  /// Not for scenes with media, layers of light, or sheets that tint, or disperse, what they let straight
  /// through. `room` is for hits once paths have ended. `steering` may be null.
  PathReuse(const IntegratorContext& context, SampleBatch& batch, int group, const Steering* steering,
            Transit& transit, HitState& room);

  void begun(const PathState& paths, const HitState& hits, int n) override;
  void met(Encounter& e) override;
  void emitted(const Encounter& e, MetLight& light) override;
  void lit(const Encounter& e, SampledLight& light) override;
  void scattered(const Encounter& e, Scattering& s) override;
  void all_lit(int depth, const PathState& paths, int n) override;
  /// The paths have ended: hands out what is shared. `queue` is empty, before and after.
  void finish(ConnectionQueue& queue);

 private:
  /// Bits for what the second surface of a sample shares.
  enum Shared : std::int32_t {
    kEven = 1,    // all
    kGlossy = 2,  // or some of what follows:
    kLight = 4,   // light of a sampled light ...
    kDelta = 8,   // ... which nothing else finds
    kFound = 16,  // light that the third surface, or the sky, emits
    kBeyond = 32  // light that the third surface sends back
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

  /// Whether at the event of `depth` paths may be at their first, second or third surfaces; if not, nothing
  /// of it matters.
  bool follows(int depth) const { return depth <= std::max(last_first_ + 2, last_mirror_ + 1); }
  /// Whether second surfaces share the light of lamps and of the sky: paths find each by one density alone.
  bool shares_lamps() const { return !scene_.straight_shadows; }
  bool shares_sky() const { return shares_lamps() && scene_.lights.infinite_lights.size() <= 1; }
  void at_first(const Encounter& e, Mask lanes);
  void at_second(Encounter& e, Mask lanes);
  void at_third(Encounter& e, Mask lanes);
  void keep(int event, const Encounter& e, Mask lanes);
  void set_apart(Int slot, Mask lanes);

  void collect(int first);
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
  void hand_out(int place, const Packet& firsts) const;

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  SampleBatch& batch_;
  const int group_;
  const Steering* const steering_;  // may be null
  Transit& transit_;
  HitState& room_;
  int size_ = 0;
  bool any_shared_ = false;
  int last_first_ = -1, last_mirror_ = -1;  // latest events at which paths have met such surfaces
  // Indexed by sample: the event of the first surface, and rays to first and second ones and what they hit
  alignas(64) Lanes<std::int32_t> first_event_;
  Vec3Lanes origin_[2], direction_[2];
  HitState hits_[2];
  Lanes<float> mix_[2];                        // scenes with mixed materials only
  Lanes<float> time_;                          // scenes with motion only
  alignas(64) Lanes<std::int32_t> dispersed_;  // PathFields::dispersed at first surfaces
  SpectrumLanes before_;                       // throughput up to the first surface, where it may not be 1
  Vec3Lanes first_;                            // points of first surfaces
  alignas(64) Lanes<std::int32_t> steered_;    // Encounter::steered of first surfaces
  Vec3Lanes p_, ng_, ns_;                      // second surfaces, seen from where the path came
  Lanes<float> error_;
  alignas(64) Lanes<std::int32_t> shared_;  // bits of Shared
  Vec3Lanes to_light_, on_;                 // directions to the sampled light, and in which the path went on
  SpectrumLanes own_;                       // radiance that is the sample's alone, as far as it is set apart
  SpectrumLanes light_, found_;             // kLight, kFound: what comes along to_light_ and on_
  Lanes<float> light_pdf_, found_pdf_;      // densities with which samples of lights find that
  SpectrumLanes suffix_;                    // kEven: what is sent back; kBeyond: what comes along on_
  Lanes<float> by_light_, by_found_, by_suffix_;  // reciprocal densities with which the group finds these
  // Samples that take part: with a first surface, with a second one that scatters evenly, with others
  Samples firsts_, evens_, glossies_;
  Lanes<std::int32_t> place_in_firsts_;  // place of each sample; -1: none
  // One for each pair
  Pairs pdf_;             // density by area of the second surface; 0: not found from there
  SpectrumPairs weight_;  // weight of the light that is sent back there
  // For directions to_light_ and on_ at the second surface, seen from the first: factors and densities; where
  // pdf_ is not 0
  SpectrumPairs of_light_, of_on_;
  Pairs pdf_light_, pdf_on_;
};

}  // namespace tessera::render::TESSERA_ISA
