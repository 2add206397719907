#include "render/integrator/path/wavefront.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <string>

#include "render/accel/replay.h"
#include "render/accel/trace.h"
#include "render/camera/camera.h"
#include "render/film/filter_sample.h"
#include "render/film/summable.h"
#include "render/integrator/path/fireflies.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

std::vector<std::uint32_t> z_order(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> order;
  order.reserve(std::size_t{width} * height);
  const std::uint32_t side = std::bit_ceil(std::max({width, height, 1u}));
  const auto every_second_bit = [](std::uint64_t code) {
    code &= 0x5555555555555555;
    code = (code | code >> 1) & 0x3333333333333333;
    code = (code | code >> 2) & 0x0f0f0f0f0f0f0f0f;
    code = (code | code >> 4) & 0x00ff00ff00ff00ff;
    code = (code | code >> 8) & 0x0000ffff0000ffff;
    return static_cast<std::uint32_t>(code | code >> 16);
  };
  for (std::uint64_t code = 0; code < std::uint64_t{side} * side; ++code) {
    const std::uint32_t x = every_second_bit(code), y = every_second_bit(code >> 1);
    if (x < width && y < height) order.push_back(y * width + x);
  }
  return order;
}

Wavefront::Wavefront(const SceneTables& scene, RenderStats& stats, RayLog* log, std::int32_t max_depth)
    : scene_(scene), stats_(stats), log_(log), max_depth_(max_depth) {}

bool Wavefront::render(const TileRequest& tile, FilmSink& film, std::stop_token stop) {
  // A batch holds several samples of as many pixels as fit: the pixels of a packet are neighbours.
  const std::vector<std::uint32_t> order = z_order(tile.x1 - tile.x0, tile.y1 - tile.y0);
  std::vector<SampleName> places;
  places.reserve(order.size());
  const std::uint32_t width = tile.x1 - tile.x0;
  for (const std::uint32_t pixel : order) places.push_back({tile.x0 + pixel % width, tile.y0 + pixel / width, 0, 0});
  seed_ = scene_.sampler.seed + tile.seed_offset;
  const std::uint32_t samples = tile.sample_end - tile.sample_begin;
  const std::size_t step = kBatch / std::min<std::uint32_t>(samples, 4);
  for (std::size_t first = 0; first < order.size(); first += step) {
    const std::size_t count = std::min(step, order.size() - first);
    film.begin_pixels(std::span(order).subspan(first, count));
    if (!render_pixels(std::span(places).subspan(first, count), tile, film, stop)) return false;
    const StageTimer timer(stats_.times, Stage::kFilm);
    film.end_pixels();
  }
  return true;
}

bool Wavefront::render_pixels(std::span<const SampleName> places, const TileRequest& tile, FilmSink& film,
                              std::stop_token stop) {
  const std::size_t n = places.size();
  const auto fit = static_cast<std::uint32_t>(kBatch / n);
  for (std::uint32_t s = tile.sample_begin; s < tile.sample_end;) {
    if (stop.stop_requested()) return false;
    const std::uint32_t samples = std::min(fit, tile.sample_end - s);
    name_samples(places, s, samples);
    const std::size_t stride = trace_samples(static_cast<int>(n * samples));
    const StageTimer timer(stats_.times, Stage::kFilm);
    for (std::uint32_t i = 0; i < samples; ++i) film.add_sample(planes_.data() + i * n, stride);
    s += samples;
  }
  return true;
}

bool Wavefront::render(SampleSource& source, std::uint64_t seed_offset, std::stop_token stop) {
  seed_ = scene_.sampler.seed + seed_offset;
  while (const std::size_t count = next_samples(source)) {
    if (stop.stop_requested()) return false;
    const std::size_t stride = trace_samples(static_cast<int>(count));
    const StageTimer timer(stats_.times, Stage::kFilm);
    source.add(planes_.data(), stride);
  }
  return true;
}

std::size_t Wavefront::next_samples(SampleSource& source) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  return source.next(std::span(names_).first(kBatch));
}

void Wavefront::name_samples(std::span<const SampleName> places, std::uint32_t first_sample, std::uint32_t samples) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  SampleName* name = names_;
  for (std::uint32_t s = 0; s < samples; ++s) {
    for (const SampleName& place : places) *name++ = {place.x, place.y, first_sample + s, 0};
  }
}

/// Leaves the batch's samples in planes_; returns the stride between its planes.
std::size_t Wavefront::trace_samples(int count) {
  start_paths(count);
  for (int depth = 0; alive_ > 0; ++depth) advance(depth);
  return finish_samples(count);
}

void Wavefront::start_paths(int count) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  shading_timer_.begin_batch(scene_.materials.materials.size());
  static_assert(sizeof(SampleName) == 16);
  for (int slot = 0; slot < count; slot += kWidth) {
    const auto* first = reinterpret_cast<const std::int32_t*>(names_ + slot);
    const Int4 name = gather4(first, Int::iota(0) * 4, Mask::all());
    const UInt px = bit_cast<std::uint32_t>(name.c[0]), py = bit_cast<std::uint32_t>(name.c[1]),
               reversed = reverse_bits(bit_cast<std::uint32_t>(name.c[2]));
    const UInt hash = Sampler::stream_hash(Sampler::pixel_hash(seed_, px, py), bit_cast<std::uint32_t>(name.c[3]));
    const Sampler sampler(scene_.sampler.kind, hash, reversed);

    // Where on the film, and where on the lens.
    const FilterSample filter = sample_filter(scene_.filter, sampler.get_2d(dimension::kFilm));
    const Vec2 film{to_float(bit_cast<std::int32_t>(px)) + 0.5f + filter.offset.x,
                    to_float(bit_cast<std::int32_t>(py)) + 0.5f + filter.offset.y};
    Float time(0.0f);
    if (scene_.any_motion) {
      time = sampler.get_2d(dimension::kTime).x;
      time.store(paths_.time + slot);
    }
    const CameraRay ray = sample_camera_ray(scene_.camera, film, sampler.get_2d(dimension::kLens), time);

    const Mask all = Mask::all();
    paths_.origin.append(ray.origin, all, slot);
    paths_.direction.append(ray.direction, all, slot);
    paths_.beta.store(Spectrum(1.0f), slot);
    Float(0.0f).store(paths_.pdf + slot);
    Float(1.0f).store(paths_.eta_scale + slot);
    Int::iota(slot).store(paths_.slot + slot);
    if (scene_.volumetric) {
      paths_.reference.append(ray.origin, all, slot);
      Int(scene_.camera.medium).store(paths_.medium + slot);
    }
    hash.store(samples_.pixel_hash + slot);
    reversed.store(samples_.reversed_sample + slot);
    filter.weight.store(samples_.filter_weight + slot);
    samples_.radiance.store(Spectrum(0.0f), slot);
    Float(0.0f).store(samples_.coverage + slot);
    Float(0.0f).store(samples_.depth + slot);
    samples_.albedo.store(Spectrum(0.0f), slot);
    samples_.normal.append({Float(0.0f), Float(0.0f), Float(0.0f)}, all, slot);
  }
  alive_ = count;
  stats_.camera_rays += static_cast<std::uint64_t>(count);
  stats_.samples += static_cast<std::uint64_t>(count);
}

void Wavefront::advance(int depth) {
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  intersect(depth);
  if (scene_.volumetric) {
    const StageTimer timer(stats_.times, Stage::kTransit);
    transit(depth);
  }
  shade(depth);
  const StageTimer timer(stats_.times, Stage::kShadow);
  if (scene_.volumetric) {
    march_shadow_rays(depth);
  } else {
    trace_shadow_rays();
  }
}

void Wavefront::intersect(int depth) {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  const RayArrays rays{paths_.origin.x,    paths_.origin.y,    paths_.origin.z,      paths_.direction.x,
                       paths_.direction.y, paths_.direction.z, times_of(paths_.time)};
  const HitArrays hits{hits_.t, hits_.u, hits_.v, hits_.primitive, hits_.shape, hits_.instance};
  const bool coherent = depth == 0 && scene_.camera.lens_radius == 0 && scene_.camera.steps.empty();
  if (log_)
    record_rays(rays, nullptr, alive_, depth == 0 ? RayLog::Kind::kCamera : RayLog::Kind::kBounce, coherent, *log_);
  trace_nearest(scene_.accel, rays, alive_, scene_.traversal(coherent),
                static_cast<std::int32_t>(scene_.shapes.shapes.size()), hits);
  if (depth == 0 && scene_.camera.far_clip > 0) clip_far();
}

void Wavefront::clip_far() {
  for (int i = 0; i < alive_; i += kWidth) {
    const Float time = scene_.any_motion ? Float::load(paths_.time + i) : Float(0.0f);
    const Mask seen = Float::load(hits_.t + i) <= visible_distance(scene_.camera, paths_.direction.load(i), time);
    select(seen, Int::load(hits_.shape + i), Int(-1)).store(hits_.shape + i);
  }
}

void Wavefront::trace_shadow_rays() {
  const RayArrays rays{shadows_.origin.x,    shadows_.origin.y,    shadows_.origin.z,      shadows_.direction.x,
                       shadows_.direction.y, shadows_.direction.z, times_of(shadows_.time)};
  if (log_) record_rays(rays, shadows_.distance, shadows_.size, RayLog::Kind::kShadow, false, *log_);
  trace_shadow(scene_.accel, rays, shadows_.size, scene_.traversal(), shadows_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(shadows_.size);
  for (int i = 0; i < shadows_.size; ++i) {
    if (shadows_.distance[i] < 0) continue;
    const std::int32_t slot = shadows_.slot[i];
    for (int c = 0; c < kSpectrumLanes; ++c) samples_.radiance.c[c][slot] += shadows_.contribution.c[c][i];
  }
  shadows_.size = 0;
}

void Wavefront::add_radiance(Spectrum more, Int slot, Mask lanes) {
  for (int c = 0; c < kSpectrumLanes; ++c) {
    float* sum = samples_.radiance.c[c];
    scatter(gather(sum, slot, lanes) + more.c[c], sum, slot, lanes);
  }
}

void Wavefront::drop_bad_samples(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask valid = Mask::first(count - i);
    const Spectrum radiance = samples_.radiance.load(i);
    Mask summable = Mask::all();
    for (int c = 0; c < kSpectrumLanes; ++c) summable &= is_summable(radiance.c[c] * scene_.exposure);
    const Mask bad = and_not(valid, summable);
    if (none(bad)) continue;
    samples_.radiance.store(select(bad, Spectrum(0.0f), radiance), i);
    for (std::uint32_t bits = bad.bits(); bits != 0; bits &= bits - 1) {
      ++stats_.dropped_samples;
      if (stats_.warnings.size() >= 8) continue;
      const SampleName& name = names_[i + std::countr_zero(bits)];
      stats_.warnings.push_back("pixel (" + std::to_string(name.x) + ", " + std::to_string(name.y) + "), sample " +
                                std::to_string(name.index) +
                                ": radiance is not finite or beyond 1e15; counted as black");
    }
  }
}

std::size_t Wavefront::finish_samples(int count) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  drop_bad_samples(count);

  // Channels in the order of wire::channels_for_aovs.
  const std::size_t stride = (static_cast<std::size_t>(count) + kWidth) / kWidth * kWidth;
  const AovRequest& aovs = scene_.aovs;
  planes_.resize((4 + (aovs.albedo ? 3 : 0) + (aovs.normal ? 3 : 0) + (aovs.depth ? 1 : 0)) * stride);
  for (int i = 0; i < count; i += kWidth) {
    const Float weight = Float::load(samples_.filter_weight + i);
    float* to = planes_.data() + i;
    const auto put = [&](Float value) {
      (value * weight).store_unaligned(to);
      to += stride;
    };
    const auto put_summable = [&](Float value) { put(select_or_zero(is_summable(value), value)); };
    const Spectrum radiance = samples_.radiance.load(i) * scene_.exposure;
    for (int c = 0; c < 3; ++c) put(radiance.c[c]);
    put(Float::load(samples_.coverage + i));
    if (aovs.albedo) {
      for (int c = 0; c < 3; ++c) put_summable(samples_.albedo.load(i).c[c]);
    }
    if (aovs.normal) {
      const Vec3 n3 = samples_.normal.load(i);
      put_summable(n3.x), put_summable(n3.y), put_summable(n3.z);
    }
    if (aovs.depth) put_summable(Float::load(samples_.depth + i));
  }
  // Where nothing is scattered, what is bright is a lamp.
  if (max_depth_ > 0) count_fireflies(planes_.data(), stride, count, stats_);
  return stride;
}

}  // namespace tessera::render::TESSERA_ISA
