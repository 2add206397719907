#include "render/transport/vertex/sample_batch.h"

#include <algorithm>
#include <bit>
#include <string>

#include "render/film/filter_sample.h"
#include "render/film/summable.h"
#include "render/integrator/fireflies.h"
#include "render/integrator/stage_timer.h"
#include "render/sampling/sample_key.h"
#include "render/sensor/respond.h"
#include "render/sensor/sensor.h"
#include "render/shape/place.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/layers.h"
#include "wire/halves.h"

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

PixelPlace common_place(const PixelFilterRecord& filter, UInt number) {
  // Steps of 1 / p and 1 / p^2 with p^3 = p + 1, from the middle on.
  const Vec2 u{to_unit_float(number * 0xc13fa9a9u + 0x80000000u),
               to_unit_float(number * 0x91e10da5u + 0x80000000u)};
  const FilterSample sample = sample_filter(filter, u);
  const auto steps = [](Float offset) {
    return to_int(floor(fma(offset, kPlaceSteps, (kPlaceSteps + 1) * 0.5f)));
  };
  return {steps(sample.offset.x), steps(sample.offset.y), sample.weight};
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

}  // namespace

bool SampleBatch::start(SampleSource& source, PathState& paths, int most, SamplePlaces places,
                        const PassShare& shared) {
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
    Float time(0.0f), weight;
    if (places == SamplePlaces::kRandom) {
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
      if (scene_.any_motion)
        // Neighbours share light of one time.
        time =
            shared.time ? Float(*shared.time) : of_first_in_group(sampler.get_2d(dimension::kTime).x, group);
    } else {
      const PixelPlace place = common_place(scene_.filter, bit_cast<std::uint32_t>(name.c[2]));
      raster = {fma(to_float(place.x), 1.0f / kPlaceSteps, raster.x),
                fma(to_float(place.y), 1.0f / kPlaceSteps, raster.y)};
      weight = place.weight;
    }
    const SensorRay ray = start_ray(scene_.sensor, {raster, lens, time});
    const Wavelengths wavelengths =
        sample_wavelengths(scene_.spectral, [&] {  // Neighbours share light of the same ones.
          return shared.wavelength ? Float(*shared.wavelength)
                                   : of_first_in_group(sampler.get_2d(dimension::kTime).y, group);
        });

    const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
    const WidePath path{.origin = ray.origin,
                        .direction = ray.direction,
                        .beta = Spectrum(ray.weight),
                        .wavelengths = wavelengths,
                        .pdf = Float(0.0f),
                        .roulette_scale = Float(1.0f),
                        .slot = Int::iota(slot),
                        .normal = zero,
                        .dispersed = Int(0),
                        .time = time,
                        .reference = ray.origin,
                        .medium = Int(scene_.sensor.medium),
                        .layer_state = state_at_eye(scene_)};
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
    store_lanes(zero, normal_, slot);
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
  for (int i = 0; i < size_; ++i) {
    if (names_[i].stream == kUnsampled) hits.shape[i] = -1;
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

Mask SampleBatch::bad_samples(int i) const {
  const Spectrum light = radiance(i);
  Mask summable = Mask::all();
  for (int c = 0; c < kSpectrumLanes; ++c)
    summable &= is_summable(exposed(scene_.sensor.response, light.c[c]));
  return and_not(Mask::first(size_ - i), summable);
}

Spectrum SampleBatch::summable_radiance(int i) {
  const Mask bad = bad_samples(i);
  stats_.dropped_samples += static_cast<std::uint64_t>(std::popcount(bad.bits()));
  return select(bad, Spectrum(0.0f), radiance(i));
}

void SampleBatch::drop_bad_samples() {
  for (int i = 0; i < size_; i += kWidth) {
    const Mask bad = bad_samples(i);
    if (none(bad)) continue;
    store_lanes(select(bad, Spectrum(0.0f), radiance(i)), radiance_, i);
    for (SpectrumLanes& layer : layers_) {
      Spectrum part;
      load_lanes(layer, i, part);
      store_lanes(select(bad, Spectrum(0.0f), part), layer, i);
    }
    for (std::uint32_t bits = bad.bits(); bits != 0; bits &= bits - 1) {
      ++stats_.dropped_samples;
      if (stats_.warnings.size() >= 8) continue;
      const SampleName& name = names_[i + std::countr_zero(bits)];
      stats_.warnings.push_back("pixel (" + std::to_string(static_cast<std::int32_t>(name.x)) + ", " +
                                std::to_string(static_cast<std::int32_t>(name.y)) + "), sample " +
                                std::to_string(name.index) +
                                ": radiance is not finite or beyond 1e15; counted as black");
    }
  }
}

/// The last of the planes, which are filled plane by plane: many are empty, batch by batch. Leaves the layers
/// black for the next batch, while they are in the cache.
void SampleBatch::fill_layers(std::size_t stride) {
  float* plane = planes_.data() + planes_.size() - kResponseChannels * layers_.size() * stride;
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
    for (int channel = 0; channel < kResponseChannels; ++channel, plane += stride) {
      if (!is_touched(layer)) {
        std::fill_n(plane, stride, 0.0f);
        continue;
      }
      for (int i = 0; i < size_; i += kWidth) {
        // Light that is part of what is summable.
        const Float light = channels_of_light(scene_.spectral, wavelengths_at(i)).of(channel, [&](int lane) {
          return Float::load(layers_[layer].c[lane] + i);
        });
        (exposed(scene_.sensor.response, light) * Float::load(filter_weight_ + i)).store_unaligned(plane + i);
      }
    }
    if (is_touched(layer)) {
      for (auto& lane : layers_[layer].c) std::fill_n(lane, stride, 0.0f);
    }
  }
  touched_ = 0;
}

/// 2 for those of 16 samples from sample i on that are in the first half, else 0: over all samples, the mean
/// is that of the half.
Float SampleBatch::half_weight(int i) const {
  alignas(64) float weight[kWidth];
  for (int lane = 0; lane < kWidth; ++lane)
    weight[lane] = wire::in_first_half(names_[i + lane].index) ? 2.0f : 0.0f;
  return Float::load(weight);
}

/// Leaves the samples in planes_, channels in the order of wire::channels_of; returns the stride
/// between them.
std::size_t SampleBatch::fill_planes() {
  const std::size_t stride = (static_cast<std::size_t>(size_) + kWidth) / kWidth * kWidth;
  const AovRequest& aovs = scene_.aovs;
  const std::size_t features = (aovs.has(HitAov::kAlbedo) ? 3 : 0) + (aovs.has(HitAov::kNormal) ? 3 : 0) +
                               (aovs.has(HitAov::kDepth) ? 1 : 0);
  planes_.resize((kResponseChannels + 1 + features + (aovs.has(HitAov::kId) ? 2 : 0) +
                  (aovs.has(HitAov::kVisits) ? 2 : 0) + (first_hits_ ? first_hits_->planes() : 0) +
                  (aovs.halves ? kResponseChannels + features : 0) + kResponseChannels * layers_.size()) *
                 stride);
  for (int i = 0; i < size_; i += kWidth) {
    Float weight = Float::load(filter_weight_ + i);
    float* to = planes_.data() + i;
    const auto put = [&](Float value) {
      (value * weight).store_unaligned(to);
      to += stride;
    };
    const auto put_summable = [&](Float value) { put(select_or_zero(is_summable(value), value)); };
    const Wavelengths wavelengths = wavelengths_at(i);
    const auto put_channels = [&](const SpectrumLanes& lanes, const Channels& channels, auto&& put_one) {
      for (int channel = 0; channel < kResponseChannels; ++channel)
        put_one(channels.of(channel, [&](int lane) { return Float::load(lanes.c[lane] + i); }));
    };
    const auto put_radiance = [&] {
      put_channels(radiance_, channels_of_light(scene_.spectral, wavelengths),
                   [&](Float value) { put(exposed(scene_.sensor.response, value)); });
    };
    const auto put_features = [&] {
      if (aovs.has(HitAov::kAlbedo))
        put_channels(albedo_, channels_of_matter(scene_.spectral, wavelengths), put_summable);
      if (aovs.has(HitAov::kNormal)) {
        for (const auto& component : {normal_.x, normal_.y, normal_.z})
          put_summable(Float::load(component + i));
      }
      if (aovs.has(HitAov::kDepth)) put_summable(Float::load(depth_ + i));
    };
    put_radiance();
    put(Float::load(coverage_ + i));
    put_features();
    if (aovs.has(HitAov::kId)) {
      for (const float* const ids : {shape_id_, instance_id_}) {
        Float::load(ids + i).store_unaligned(to);
        to += stride;
      }
    }
    if (aovs.has(HitAov::kVisits)) {
      for (const std::int32_t* const counts : {visited_nodes_, visited_primitives_})
        put(to_float(Int::load(counts + i)));
    }
    if (first_hits_) to = first_hits_->put(i, weight, Float::load(coverage_ + i) > 0.0f, to, stride);
    if (!aovs.halves) continue;
    weight = weight * half_weight(i);
    put_radiance();
    put_features();
  }
  fill_layers(stride);
  return stride;
}

void SampleBatch::finish(Film& film, bool scattered) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  drop_bad_samples();
  const std::size_t stride = fill_planes();
  if (scattered) count_fireflies(planes_.data(), stride, size_, stats_);
  film.add(std::span(names_).first(static_cast<std::size_t>(size_)), planes_.data(), stride);
}

}  // namespace tessera::render::TESSERA_ISA
