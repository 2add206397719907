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

Wavefront::Wavefront(const SceneTables& scene, const TileRequest& tile, FilmSink& film, RenderStats& stats, RayLog* log,
                     std::int32_t max_depth)
    : scene_(scene),
      tile_(tile),
      film_(film),
      stats_(stats),
      log_(log),
      max_depth_(max_depth),
      order_(z_order(tile.x1 - tile.x0, tile.y1 - tile.y0)) {
  const std::uint32_t width = tile.x1 - tile.x0;
  for (const std::uint32_t pixel : order_) {
    pixel_x_.push_back(tile.x0 + pixel % width);
    pixel_y_.push_back(tile.y0 + pixel / width);
  }
}

bool Wavefront::render(std::stop_token stop) {
  // A batch holds several samples of as many pixels as fit: the pixels of a packet are neighbours.
  const std::uint32_t samples = tile_.sample_end - tile_.sample_begin;
  const std::size_t step = kBatch / std::min<std::uint32_t>(samples, 4);
  for (std::size_t first = 0; first < order_.size(); first += step) {
    const auto pixels = std::span(order_).subspan(first, std::min(step, order_.size() - first));
    film_.begin_pixels(pixels);
    if (!render_pixels(pixels, stop)) return false;
    const StageTimer timer(stats_.times, Stage::kFilm);
    film_.end_pixels();
  }
  return true;
}

bool Wavefront::render_pixels(std::span<const std::uint32_t> pixels, std::stop_token stop) {
  const auto fit = static_cast<std::uint32_t>(kBatch / pixels.size());
  for (std::uint32_t s = tile_.sample_begin; s < tile_.sample_end;) {
    if (stop.stop_requested()) return false;
    const auto samples = static_cast<int>(std::min(fit, tile_.sample_end - s));
    start_paths(pixels, s, samples);
    for (int depth = 0; alive_ > 0; ++depth) advance(depth);
    finish_samples(pixels, s, samples);
    s += static_cast<std::uint32_t>(samples);
  }
  return true;
}

void Wavefront::start_paths(std::span<const std::uint32_t> pixels, std::uint32_t first_sample, int samples) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  shading_timer_.begin_batch(scene_.materials.materials.size());
  const int count = static_cast<int>(pixels.size()) * samples;
  const auto first_pixel = static_cast<std::size_t>(pixels.data() - order_.data());
  const std::uint32_t *all_x = pixel_x_.data() + first_pixel, *all_y = pixel_y_.data() + first_pixel;
  std::size_t pixel = 0;
  std::uint32_t index = first_sample;
  for (int slot = 0; slot < count; slot += kWidth) {
    UInt px, py, sample;
    if (pixel + kWidth <= pixels.size()) {
      px = UInt::load_unaligned(all_x + pixel), py = UInt::load_unaligned(all_y + pixel), sample = UInt(index);
      pixel += kWidth;
      if (pixel == pixels.size()) pixel = 0, ++index;
    } else {
      // The packet holds the last pixels of one sample and the first of the next.
      alignas(64) std::uint32_t x[kWidth] = {}, y[kWidth] = {}, s[kWidth] = {};
      for (int i = 0; i < kWidth && slot + i < count; ++i) {
        x[i] = all_x[pixel], y[i] = all_y[pixel], s[i] = index;
        if (++pixel == pixels.size()) pixel = 0, ++index;
      }
      px = UInt::load(x), py = UInt::load(y), sample = UInt::load(s);
    }
    const UInt reversed = reverse_bits(sample);
    const UInt hash = Sampler::pixel_hash(scene_.sampler.seed + tile_.seed_offset, px, py);
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

void Wavefront::drop_bad_samples(std::span<const std::uint32_t> pixels, std::uint32_t first_sample, int count) {
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
      const auto slot = static_cast<std::size_t>(i + std::countr_zero(bits));
      const std::uint32_t pixel = pixels[slot % pixels.size()], width = tile_.x1 - tile_.x0;
      const std::size_t sample = first_sample + slot / pixels.size();
      stats_.warnings.push_back("pixel (" + std::to_string(tile_.x0 + pixel % width) + ", " +
                                std::to_string(tile_.y0 + pixel / width) + "), sample " + std::to_string(sample) +
                                ": radiance is not finite or beyond 1e15; counted as black");
    }
  }
}

void Wavefront::finish_samples(std::span<const std::uint32_t> pixels, std::uint32_t first_sample, int samples) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  const std::size_t n = pixels.size();
  const int count = static_cast<int>(n) * samples;
  drop_bad_samples(pixels, first_sample, count);

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
  for (int s = 0; s < samples; ++s) film_.add_sample(planes_.data() + static_cast<std::size_t>(s) * n, stride);
}

}  // namespace tessera::render::TESSERA_ISA
