// Samples of the film on their way: named by a source, started through the camera, and given to the film once
// their paths have ended. What all algorithms share whose paths begin at the eye.
#pragma once

#include <bit>
#include <memory>
#include <optional>
#include <vector>

#include "render/film/film.h"
#include "render/integrator/integrator.h"
#include "render/sampling/sampler.h"
#include "render/sensor/respond.h"
#include "render/transport/vertex/first_hits.h"
#include "render/transport/vertex/layer_sums.h"
#include "render/transport/vertex/pass_share.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/probe_media.h"
#include "render/transport/vertex/sample_keys.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Whether paths that begin at the sensor one after the other are neighbours on its raster.
enum class PathOrder { kNeighbours, kAny };

/// Finds what `n` paths meet after `depth` events. Of what rays from the sensor meet, what it does not see is
/// a miss: things beyond its far plane, and all that is met by rays which have never left it.
void find_hits(const SceneTables& scene, const RayQuery& rays, const PathState& paths, int n, int depth,
               PathOrder order, HitState& hits);

class SampleBatch {
 public:
  explicit SampleBatch(const IntegratorContext& context)
      : scene_(context.scene),
        rays_(context.rays),
        sampler_seed_(context.seed),
        stats_(context.stats),
        probe_media_(make_probe_media(context)),
        layers_(static_cast<std::size_t>(context.scene.layers.count)) {
    if (FirstHits::are_wanted(scene_.aovs)) first_hits_ = std::make_unique<FirstHits>(scene_);
  }

  /// Asks for the next samples, `most` of them, and starts a path for each: entries 0 .. size() - 1 of
  /// `paths`, in slots of the same number. False when nothing more is wanted. Where pixels are readings of
  /// probes, light that shines straight on them is appended to `probe_light`, if that is given.
  bool start(SampleSource& source, PathState& paths, int most = kBatch, const PassShare& shared = {},
             ConnectionQueue* probe_light = nullptr);
  /// Finds what the first `n` paths meet after `depth` events: find_hits() of neighbours, timed and counted,
  /// in which camera rays that nobody samples (kUnsampled) miss.
  void find_hits(const PathState& paths, int n, int depth, HitState& hits);
  /// Begins `n` samples that are none of the film's: number `first` of the sequence of `key`, and those after
  /// it.
  void start(std::uint32_t key, std::uint32_t first, int n);
  /// The paths have ended. Fireflies are counted where light was `scattered`: where not, what is bright is a
  /// lamp.
  void finish(Film& film, bool scattered);

  int size() const { return size_; }
  const SampleName& name(int slot) const { return names_[slot]; }

  /// The random numbers of samples.
  Sampler sampler(Int slot, Mask active) const { return keys_.sampler(scene_.sampler.kind, slot, active); }
  /// A key that all samples have for themselves.
  UInt key(Int slot, Mask active) const { return keys_.key(slot, active); }
  /// Colours of the scene as these samples see them.
  Spectra spectra(Int slot, Mask active) const {
    return {scene_.spectral, gather_lanes<Wavelengths>(wavelengths_, slot, active)};
  }
  const SampleKeys& keys() const { return keys_; }

  /// The radiance of 16 samples from sample i on.
  Spectrum radiance(int i) const {
    Spectrum result;
    load_lanes(radiance_, i, result);
    return result;
  }
  /// The same; black, and counted as dropped, where it is not finite or beyond 1e15.
  Spectrum summable_radiance(int i);
  /// Takes the radiance of these samples from them.
  Spectrum take_radiance(Int slot, Mask lanes) {
    const Spectrum light = gather_lanes<Spectrum>(radiance_, slot, lanes);
    scatter_lanes(Spectrum(0.0f), radiance_, slot, lanes);
    return light;
  }
  /// Sets that of 16 samples from sample i on.
  void set_radiance(Spectrum light, int i) { store_lanes(light, radiance_, i); }
  /// radiance += more, for samples that are all different.
  void add_radiance(Spectrum more, Int slot, Mask lanes);
  /// The same for samples of which several may be one.
  void add_each(Spectrum more, Int slot, Mask lanes);
  /// The same, for the layers whose bits are set, where there are any.
  void add_to_layers(Spectrum more, Int layers, Int slot, Mask lanes);
  /// The same, for layers of weighted and of unweighted light.
  void add_to_layers(Spectrum weighted, Spectrum unweighted, Int layers, Int slot, Mask lanes) {
    const std::int32_t apart = scene_.layers.unweighted;
    add_to_layers(weighted, layers & Int(~apart), slot, lanes);
    if (apart != 0) add_to_layers(unweighted, layers & Int(apart), slot, lanes);
  }
  void add_to_layers(const WideConnection& ray, Mask arrived) {
    const Spectrum light = ray.contribution;
    add_to_layers(light, scene_.layers.unweighted != 0 ? light * ray.inverse_weight : light, ray.layers,
                  ray.slot, arrived);
  }
  /// The same, for each layer its sum.
  void add_to_layers(const LayerSums& sums, Int slot, Mask lanes);
  /// radiance += contribution, and the same for its layers, for rays of samples that are all different.
  void add_contribution(const WideConnection& ray, Mask arrived) {
    add_radiance(ray.contribution, ray.slot, arrived);
    if (!layers_.empty()) add_to_layers(ray, arrived);
  }
  /// The same, for those of the queue that nothing is in the way of, which samples may share; empties it.
  void trace(ConnectionQueue& queue);
  /// Makes the ray one of these samples.
  void name(WideConnection& ray, Int slot, Mask lanes) const {
    ray.slot = slot;
    if (scene_.volumetric) ray.key = bit_cast<std::int32_t>(key(slot, lanes));
  }

  /// Records what these samples' camera rays met first, on surfaces or in media.
  void record_first_hit(const Vertex& v, const Hit& found, Int slot, Mask met);

 private:
  void miss_unsampled(HitState& hits) const;
  void record_ids(const Hit& found, Int slot, Mask hit);
  void name_next(SampleSource& source, int most);
  /// Counts what the camera rays visit, by a search of their own: all algorithms have it alike.
  void count_visits(const PathState& sensor_rays);
  /// Returns those of 16 samples from sample i on whose radiance cannot be summed.
  Mask bad_samples(int i) const;
  void drop_bad_samples();
  Float half_weight(int i) const;
  Wavelengths wavelengths_at(int i) const {
    Wavelengths result;
    load_lanes(wavelengths_, i, result);
    return result;
  }
  std::size_t fill_planes();
  void put_bands(int i, const Wavelengths& wavelengths, const Channels& channels, std::size_t stride);
  void put_layers(int i, const Channels& channels, std::size_t stride);
  void end_layers(std::size_t stride);
  bool is_touched(std::size_t layer) const { return (touched_ >> layer & 1) != 0; }
  /// Calls f for those whose bits are set.
  template <class F>
  void for_each_layer(std::int32_t bits, F&& f) {
    touched_ |= static_cast<std::uint32_t>(bits);
    for (auto left = static_cast<std::uint32_t>(bits); left != 0; left &= left - 1)
      f(layers_[static_cast<std::size_t>(std::countr_zero(left))]);
  }

  const SceneTables& scene_;
  const RayQuery& rays_;
  const std::uint64_t sampler_seed_;
  RenderStats& stats_;
  const std::unique_ptr<ProbeMedia> probe_media_;  // may be none
  int size_ = 0;
  SampleName names_[kPadded] = {};
  SampleKeys keys_;
  // One entry a sample
  SpectrumLanes radiance_;
  [[no_unique_address]] WavelengthLanes wavelengths_;
  alignas(64) Lanes<float> filter_weight_, coverage_, depth_, shape_id_, instance_id_;
  alignas(64) Lanes<std::int32_t> visited_nodes_, visited_primitives_;
  SpectrumLanes albedo_;
  Vec3Lanes normal_;
  std::unique_ptr<FirstHits> first_hits_;  // null: none of its AOVs are wanted
  std::vector<SpectrumLanes> layers_;      // radiance of each
  std::uint32_t touched_ = 0;              // bits of the layers of which some sample of the batch has light
  std::vector<float> planes_;              // values for the film, channel by channel
};

}  // namespace tessera::render::TESSERA_ISA
