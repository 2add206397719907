#include "render/transport/vertex/sample_batch.h"

#include <bit>

#include "render/film/filter_sample.h"
#include "render/integrator/stage_timer.h"
#include "render/sampling/sample_key.h"
#include "render/sensor/shutter.h"
#include "render/shape/place.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/probe_light.h"
#include "render/transport/vertex/sensor_start.h"

namespace tessera::render::TESSERA_ISA {

using wire::HitAov;

void find_hits(const SceneTables& scene, const RayQuery& rays, const PathState& paths, int n, int depth,
               PathOrder order, HitState& hits) {
  const bool coherent = depth == 0 && order == PathOrder::kNeighbours && starts_coherent_rays(scene.sensor);
  rays.nearest(arrays_of(paths.origin, paths.direction, scene.any_motion ? paths.time : nullptr), n, coherent,
               hits.arrays());
  if (depth > 0 || !misses_some_hits(scene.sensor)) return;
  for (int i = 0; i < n; i += kWidth) {
    const WidePath path = load(scene, paths, i);
    const Float time = scene.any_motion ? path.time : Float(0.0f);
    const Mask reached = is_within_reach(scene.sensor, path.direction, Float::load(hits.t + i), time);
    const Mask seen = and_not(reached, is_black(path.beta));
    select(seen, Int::load(hits.shape + i), Int(-1)).store(hits.shape + i);
  }
}

namespace {

/// Returns what the first pixel of each group has, for all of the group.
template <class T>
Wide<T> of_first_in_group(Wide<T> each, int group) {
  if (group == 1) return each;
  alignas(64) T values[kWidth];
  each.store(values);
  return gather(values, Int::iota(0) & Int(-group), Mask::all());
}

/// The moments of samples, whose neighbours share light of one time; no motion, no time.
Exposure exposure_of(const SceneTables& scene, Vec2 raster, const Sampler& sampler, int group,
                     const PassShare& shared) {
  if (!scene.any_motion) return {Float(0.0f), Float(1.0f)};
  const bool common = shared.time || shared.times_of_lights;
  const Float u = shared.time ? Float(0.0f) : of_first_in_group(sampler.get_2d(dimension::kTime).x, group);
  if (!common) return exposure_of_groups(scene.sensor, raster, u, group);
  const Float time = shared.time ? Float(*shared.time) : time_of_light(scene.sensor, u);
  return {time, exposure_at(scene.sensor, raster, time)};
}

}  // namespace

bool SampleBatch::start(SampleSource& source, PathState& paths, int most, const PassShare& shared,
                        ConnectionQueue* probe_light) {
  name_next(source, most);
  const CommonPlaces* const common = source.places();
  const StageTimer timer(stats_.times, Stage::kCamera);
  static_assert(sizeof(SampleName) == 16);
  SamplerConfig config = scene_.sampler;
  config.seed = sampler_seed_;
  const int group = source.group().count();
  for (int slot = 0; slot < size_; slot += kWidth) {
    const auto* first = reinterpret_cast<const std::int32_t*>(names_ + slot);
    const Int4 name = gather4(first, Int::iota(0) * 4, Mask::all());
    const UInt px = bit_cast<std::uint32_t>(name.c[0]), py = bit_cast<std::uint32_t>(name.c[1]),
               stream = bit_cast<std::uint32_t>(name.c[3]);
    SampleKey key = sample_key(config, px, py, bit_cast<std::uint32_t>(name.c[2]));
    key.pixel = Sampler::stream_hash(key.pixel, stream);
    const Sampler sampler(scene_.sampler.kind, key.pixel, key.reversed_sample);

    // Where on the raster, and where on the lens.
    Vec2 raster{to_float(bit_cast<std::int32_t>(px)), to_float(bit_cast<std::int32_t>(py))};
    Vec2 lens{Float(0.5f), Float(0.5f)};
    Float weight;
    if (common != nullptr) {
      const Int number = name.c[2] - static_cast<std::int32_t>(common->first);
      const Mask named = Mask::first(size_ - slot);
      raster = {raster.x + gather(common->x, number, named), raster.y + gather(common->y, number, named)};
      weight = Float(1.0f);
    } else {
      const FilterSample filter = sample_filter(scene_.filter, sampler.get_2d(dimension::kFilm));
      raster = {raster.x + 0.5f + filter.offset.x, raster.y + 0.5f + filter.offset.y};
      weight = filter.weight;
    }
    if (has_lens(scene_.sensor)) lens = sampler.get_2d(dimension::kLens);
    const Exposure exposure = exposure_of(scene_, raster, sampler, group, shared);
    weight = weight * exposure.weight;
    const Wavelengths wavelengths = sample_wavelengths(
        scene_.sensor.response.sensitivity, [&] {  // Neighbours share light of the same ones.
          return shared.wavelength ? Float(*shared.wavelength)
                                   : of_first_in_group(sampler.get_2d(dimension::kTime).y, group);
        });

    WidePath path = start_at_sensor(scene_, {raster, lens, exposure.time}, wavelengths, Int::iota(slot));
    path.layer_state = state_at_eye(scene_);
    if (probe_media_) probe_media_->enter(path, Mask::first(size_ - slot));
    if (scene_.sensor.probes && probe_light != nullptr)
      append_probe_light(scene_, px, py, sampler, key.pixel, Mask::first(size_ - slot), path, *probe_light);
    store(scene_, path, paths, slot);
    key.pixel.store(keys_.pixel_hash + slot);
    key.reversed_sample.store(keys_.reversed_sample + slot);
    weight.store(filter_weight_ + slot);
    store_lanes(Spectrum(0.0f), radiance_, slot);
    store_lanes(wavelengths, wavelengths_, slot);
    Float(0.0f).store(coverage_ + slot);
    Float(0.0f).store(depth_ + slot);
    if (scene_.aovs.of_hits()) {
      Float(0.0f).store(shape_id_ + slot);
      Float(0.0f).store(instance_id_ + slot);
    }
    if (first_hits_) first_hits_->clear(slot);
    store_lanes(Spectrum(0.0f), albedo_, slot);
    store_lanes(Vec3{Float(0.0f), Float(0.0f), Float(0.0f)}, normal_, slot);
  }
  if (scene_.aovs.has(HitAov::kVisits)) count_visits(paths);
  stats_.camera_rays += static_cast<std::uint64_t>(size_);
  stats_.samples += static_cast<std::uint64_t>(size_);
  return size_ > 0;
}

void SampleBatch::find_hits(const PathState& paths, int n, int depth, HitState& hits) {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(n);
  TESSERA_ISA::find_hits(scene_, rays_, paths, n, depth, PathOrder::kNeighbours, hits);
  if (depth == 0) miss_unsampled(hits);
}

void SampleBatch::miss_unsampled(HitState& hits) const {
  // Samples at times at which their row is not exposed count for nothing.
  const bool may_be_closed = scene_.any_motion && scene_.sensor.shutter != nullptr;
  for (int i = 0; i < size_; ++i) {
    if (names_[i].stream == kUnsampled || (may_be_closed && filter_weight_[i] == 0)) hits.shape[i] = -1;
  }
}

void SampleBatch::count_visits(const PathState& sensor_rays) {
  HitState hits;
  HitArrays arrays = hits.arrays();
  arrays.visited_nodes = visited_nodes_, arrays.visited_primitives = visited_primitives_;
  rays_.nearest(
      arrays_of(sensor_rays.origin, sensor_rays.direction, scene_.any_motion ? sensor_rays.time : nullptr),
      size_, true, arrays);
}

void SampleBatch::start(std::uint32_t key, std::uint32_t first, int n) {
  size_ = n;
  for (int slot = 0; slot < size_; slot += kWidth) {
    UInt(key).store(keys_.pixel_hash + slot);
    reverse_bits(UInt::iota(first + static_cast<std::uint32_t>(slot))).store(keys_.reversed_sample + slot);
    store_lanes(Spectrum(0.0f), radiance_, slot);
  }
}

void SampleBatch::name_next(SampleSource& source, int most) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  size_ = static_cast<int>(source.next(std::span(names_).first(static_cast<std::size_t>(most))));
}

void SampleBatch::add_radiance(Spectrum more, Int slot, Mask lanes) {
  for (int c = 0; c < kSpectrumLanes; ++c) {
    float* sum = radiance_.c[c];
    scatter(gather(sum, slot, lanes) + more.c[c], sum, slot, lanes);
  }
}

void SampleBatch::add_each(Spectrum more, Int slot, Mask lanes) {
  alignas(64) std::int32_t slots[kWidth];
  slot.store(slots);
  for (int c = 0; c < kSpectrumLanes; ++c) {
    alignas(64) float light[kWidth];
    more.c[c].store(light);
    for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1)
      radiance_.c[c][slots[__builtin_ctz(bits)]] += light[__builtin_ctz(bits)];
  }
}

void SampleBatch::add_to_layers(Spectrum more, Int layers, Int slot, Mask lanes) {
  if (layers_.empty()) return;
  alignas(64) std::int32_t to[kWidth], at[kWidth];
  alignas(64) float light[kSpectrumLanes][kWidth];
  layers.store(to);
  slot.store(at);
  for (int c = 0; c < kSpectrumLanes; ++c) more.c[c].store(light[c]);
  for (std::uint32_t left = lanes.bits(); left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    for_each_layer(to[i], [&](SpectrumLanes& layer) {
      for (int c = 0; c < kSpectrumLanes; ++c) layer.c[c][at[i]] += light[c][i];
    });
  }
}

void SampleBatch::add_to_layers(const LayerSums& sums, Int slot, Mask lanes) {
  sums.for_each([&](int layer, const Spectrum& more) {
    touched_ |= 1u << layer;
    SpectrumLanes& to = layers_[static_cast<std::size_t>(layer)];
    for (int c = 0; c < kSpectrumLanes; ++c)
      scatter(gather(to.c[c], slot, lanes) + more.c[c], to.c[c], slot, lanes);
  });
}

void SampleBatch::trace(ConnectionQueue& queue) {
  const float* const times = scene_.any_motion ? queue.time : nullptr;
  rays_.occluded(arrays_of(queue.origin, queue.direction, times), queue.size, queue.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(queue.size);
  const auto add = [&](int i) {
    const std::int32_t slot = queue.slot[i];
    for (int c = 0; c < kSpectrumLanes; ++c) radiance_.c[c][slot] += queue.contribution.c[c][i];
    if (layers_.empty()) return;
    const std::int32_t apart = scene_.layers.unweighted;
    for_each_layer(queue.layers[i] & ~apart, [&](SpectrumLanes& layer) {
      for (int c = 0; c < kSpectrumLanes; ++c) layer.c[c][slot] += queue.contribution.c[c][i];
    });
    if (apart == 0) return;
    for_each_layer(queue.layers[i] & apart, [&](SpectrumLanes& layer) {
      for (int c = 0; c < kSpectrumLanes; ++c)
        layer.c[c][slot] += queue.contribution.c[c][i] * queue.inverse_weight[i];
    });
  };
  // Which arrive is not to be guessed: a branch for 16, not one for each.
  for (int first = 0; first < queue.size; first += kWidth) {
    const Mask blocked = Float::load(queue.distance + first) < 0.0f;
    const std::uint32_t arrived = and_not(Mask::first(queue.size - first), blocked).bits();
    for (std::uint32_t bits = arrived; bits != 0; bits &= bits - 1) add(first + std::countr_zero(bits));
  }
  queue.size = 0;
}

void SampleBatch::record_first_hit(const Vertex& v, const Hit& found, Int slot, Mask met) {
  scatter(Float(1.0f), coverage_, slot, met);
  if (scene_.aovs.has(HitAov::kDepth)) scatter(found.t, depth_, slot, met);
  if (scene_.aovs.has(HitAov::kNormal)) scatter_lanes(face_forward(v.at.frame.z, v.wo), normal_, slot, met);
  if (scene_.aovs.has(HitAov::kAlbedo)) scatter_lanes(albedo_of(v.at, met), albedo_, slot, met);
  if (first_hits_) first_hits_->record(v, slot, met);
  if (!scene_.aovs.of_hits()) return;
  const Mask hit = and_not(met, v.in_medium);
  record_ids(found, slot, hit);
  if (first_hits_ == nullptr) return;
  first_hits_->record_hit(found, gather(shape_id_, slot, hit), gather(instance_id_, slot, hit), slot, hit);
}

void SampleBatch::record_ids(const Hit& found, Int slot, Mask hit) {
  const ShapeTable& table = scene_.shapes;
  const Int shape = gather_member(table.shapes.data(), &ShapeRecord::number, found.shape, hit);
  scatter(to_float(shape), shape_id_, slot, hit);
  const Mask placed = hit & (found.instance >= 0);
  if (none(placed)) return;
  if (table.nested()) {
    alignas(64) std::int32_t instance[kWidth], upper[kWidth], to[kWidth];
    found.instance.store(instance), found.upper.store(upper), slot.store(to);
    for (std::uint32_t bits = placed.bits(); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      const std::int64_t place = place_number(instance[lane], upper[lane]);
      // That of the outermost instance that has one: the world's may be held by an object of their own.
      std::int32_t number = 0;
      for_each_level(table, place,
                     [&](const InstanceRecord& at) { number = number > 0 ? number : at.number; });
      instance_id_[to[lane]] = static_cast<float>(number);
    }
    return;
  }
  const Int instance = gather_member(table.instances.data(), &InstanceRecord::number, found.instance, placed);
  scatter(to_float(instance), instance_id_, slot, placed);
}

}  // namespace tessera::render::TESSERA_ISA
