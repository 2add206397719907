// Vertex merging: the light of a vertex from that of photons close by, which are vertices of subpaths from
// lights [Georgiev et al. 2012]. With joins, and weighed against them by the same sums: vertex connection and
// merging.
//
// All light of a pass is caught before its picture begins. The radius is a function of the pass alone, so
// passes are independent, and the mean of many goes to the right picture as their radii go to zero
// [Knaus & Zwicker 2011].
#pragma once

#include <cstdint>

#include "render/transport/bdpt/light_subpaths.h"
#include "render/transport/photon_map/photon_map.h"
#include "render/transport/vertex/layers.h"

namespace tessera::render::TESSERA_ISA {

/// A vertex of a subpath from a light.
template <class Form>
struct alignas(64) MergeablePhotonFields {
  typename Form::Vector position;
  typename Form::Vector direction;  // unit, back to the light
  typename Form::Colour flux;
  typename Form::Scalar last, rest;  // PartialWeights
  typename Form::Integer steps;      // events before this one: photon_steps.h

  template <class F, class... Photons>
  static void for_each(F&& f, Photons&... photons) {
    f(photons.position...);
    f(photons.direction...);
    f(photons.flux...);
    f(photons.last...);
    f(photons.rest...);
    f(photons.steps...);
  }
};

class Merging final : public LightVertexSink {
 public:
  /// `first_radius`: of the first pass, in units of render space; 0: a part of the scene's size.
  explicit Merging(const SceneTables& scene, float first_radius = 0);

  /// Most photons that are expected of a pass: 48 bytes each, twice while they are sorted.
  static constexpr std::int64_t kMostPhotons = 1 << 22;

  /// Has to be told, before the first pass, how many vertices a subpath has that are caught, in the mean.
  void expect(double photons_a_path);
  bool knows_what_to_expect() const { return stride_ > 0; }

  /// Whether vertices of the pass's batch number `batch` of kSubpaths subpaths are to be caught: of large
  /// films, and where subpaths are long, not those of all, so that memory is bounded.
  bool wants_batch(std::uint32_t batch) const { return batch % stride_ == 0; }

  void begin(std::uint32_t pass);
  void add(const LightVertex& vertices, int event) override;
  /// All light of the pass has been caught.
  void end() { map_.build(radius_); }

  std::int64_t photons() const { return map_.size(); }

  /// Returns what merging a vertex adds to the sums over ways, before powers: how many photons a vertex meets
  /// for one that would be joined.
  float photons_a_join() const {
    return static_cast<float>(photon_paths_) * (area() * UnitArea(scene_.lights).inverse);
  }

  /// Weighed reflected light of the photons near the vertices `at`, on surfaces. `eye`: sums there, at event
  /// `depth`; `dispersed`: of the paths there, PathFields::dispersed. Adds it to `layers` too, unless that is
  /// null.
  Spectrum gather(const Vertex& at, const PartialWeights& eye, int depth, Int dispersed, Mask active,
                  GatheredLayers* layers) const;

 private:
  float area() const;

  const SceneTables& scene_;
  const float first_radius_;
  std::uint32_t stride_ = 0;
  std::int64_t photon_paths_ = 1;  // a pass
  float radius_ = 0;
  PhotonMap<MergeablePhotonFields> map_;
};

}  // namespace tessera::render::TESSERA_ISA
