// The samples of a batch as planes for the film.
#include <algorithm>
#include <bit>
#include <string>

#include "render/film/summable.h"
#include "render/integrator/fireflies.h"
#include "render/integrator/stage_timer.h"
#include "render/sensor/respond.h"
#include "render/transport/vertex/sample_batch.h"
#include "wire/halves.h"

namespace tessera::render::TESSERA_ISA {

using wire::HitAov;

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

/// Adds the light of 16 samples from sample i on to the planes of the bands, which lie before those of the
/// layers.
void SampleBatch::put_bands(int i, const Wavelengths& wavelengths, const Channels& channels,
                            std::size_t stride) {
#ifdef TESSERA_SPECTRAL
  const Response& response = scene_.sensor.response;
  const auto bands = static_cast<std::size_t>(response.sensitivity.bands);
  float* const planes =
      planes_.data() + planes_.size() - (kResponseChannels * layers_.size() + bands) * stride;
  const Float filter = Float::load(filter_weight_ + i);
  for (int lane = 0; lane < kSpectrumLanes; ++lane) {
    const BandShare share = band_share(response.sensitivity, wavelengths, channels, lane);
    alignas(64) std::int32_t band[kWidth];
    alignas(64) float light[kWidth];
    share.band.store(band);
    (exposed(response, Float::load(radiance_.c[lane] + i) * share.weight) * filter).store(light);
    for (int k = 0; k < kWidth; ++k) {
      if (band[k] >= 0)
        planes[static_cast<std::size_t>(band[k]) * stride + static_cast<std::size_t>(i + k)] += light[k];
    }
  }
#else
  (void)i, (void)wavelengths, (void)channels, (void)stride;
#endif
}

/// Fills the part of the layers' planes, which are the last, that is of 16 samples from sample i on.
void SampleBatch::put_layers(int i, const Channels& channels, std::size_t stride) {
  float* plane = planes_.data() + planes_.size() - kResponseChannels * layers_.size() * stride;
  const Float weight = Float::load(filter_weight_ + i);
  for (std::size_t layer = 0; layer < layers_.size(); ++layer, plane += kResponseChannels * stride) {
    if (!is_touched(layer)) continue;
    for (int channel = 0; channel < kResponseChannels; ++channel) {
      // Light that is part of what is summable.
      const Float light =
          channels.of(channel, [&](int lane) { return Float::load(layers_[layer].c[lane] + i); });
      (exposed(scene_.sensor.response, light) * weight)
          .store_unaligned(plane + static_cast<std::size_t>(channel) * stride + i);
    }
  }
}

/// Makes the planes of layers without light black, which many are, batch by batch. Leaves the layers black
/// for the next batch, while they are in the cache.
void SampleBatch::end_layers(std::size_t stride) {
  float* plane = planes_.data() + planes_.size() - kResponseChannels * layers_.size() * stride;
  for (std::size_t layer = 0; layer < layers_.size(); ++layer, plane += kResponseChannels * stride) {
    if (is_touched(layer)) {
      for (auto& lane : layers_[layer].c) std::fill_n(lane, stride, 0.0f);
    } else {
      std::fill_n(plane, kResponseChannels * stride, 0.0f);
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
  const auto bands = static_cast<std::size_t>(scene_.sensor.response.sensitivity.bands);
  planes_.resize((kResponseChannels + 1 + features + (aovs.has(HitAov::kId) ? 2 : 0) +
                  (aovs.has(HitAov::kVisits) ? 2 : 0) + (first_hits_ ? first_hits_->planes() : 0) +
                  (aovs.halves ? kResponseChannels + features : 0) + bands +
                  kResponseChannels * layers_.size()) *
                 stride);
  std::fill_n(
      planes_.end() - static_cast<std::ptrdiff_t>((kResponseChannels * layers_.size() + bands) * stride),
      bands * stride, 0.0f);
  for (int i = 0; i < size_; i += kWidth) {
    Float weight = Float::load(filter_weight_ + i);
    float* to = planes_.data() + i;
    const auto put = [&](Float value) {
      (value * weight).store_unaligned(to);
      to += stride;
    };
    const auto put_summable = [&](Float value) { put(select_or_zero(is_summable(value), value)); };
    const Wavelengths wavelengths = wavelengths_at(i);
    const Channels channels = channels_of_light(scene_.sensor.response, wavelengths);
    Channels of_matter;
    if (aovs.has(HitAov::kAlbedo)) of_matter = channels_of_matter(scene_.sensor.response, wavelengths);
    const auto put_channels = [&](const SpectrumLanes& lanes, const Channels& seen, auto&& put_one) {
      for (int channel = 0; channel < kResponseChannels; ++channel)
        put_one(seen.of(channel, [&](int lane) { return Float::load(lanes.c[lane] + i); }));
    };
    const auto put_radiance = [&] {
      put_channels(radiance_, channels, [&](Float value) { put(exposed(scene_.sensor.response, value)); });
    };
    const auto put_features = [&] {
      if (aovs.has(HitAov::kAlbedo)) put_channels(albedo_, of_matter, put_summable);
      if (aovs.has(HitAov::kNormal)) {
        for (const auto& component : {normal_.x, normal_.y, normal_.z})
          put_summable(Float::load(component + i));
      }
      if (aovs.has(HitAov::kDepth)) put_summable(Float::load(depth_ + i));
    };
    put_radiance();
    if (!layers_.empty()) put_layers(i, channels, stride);
    if (bands > 0) put_bands(i, wavelengths, channels, stride);
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
  end_layers(stride);
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
