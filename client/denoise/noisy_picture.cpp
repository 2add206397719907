#include "denoise/noisy_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "denoise/feature_filter.h"
#include "import/input/parallel.h"
#include "wire/colour_channels.h"
#include "wire/halves.h"

namespace tessera::client::denoise {
namespace {

constexpr auto kColours = wire::kColourChannels;
/// Light beyond this is taken for it: squares of it are still numbers.
constexpr float kBrightest = 1e15f;

/// Reads channels of an image, whose pixels may be anything.
class Reader {
 public:
  explicit Reader(const Image& image) : image_(image) {}

  /// The channel without margin, what is not finite as 0; that is counted in `bad`, a flag a pixel.
  Plane read(const std::string& name, std::vector<char>* bad = nullptr) {
    Plane plane(image_.data.width(), image_.data.height());
    const Channel* const channel = image_.find(name);
    if (channel == nullptr) {
      missing_ += absl::StrCat(missing_.empty() ? "" : ", ", name);
      return plane;
    }
    std::size_t i = 0;
    for (int y = 0; y < plane.height(); ++y) {
      for (int x = 0; x < plane.width(); ++x, ++i) {
        const float value = channel->values[i];
        const bool finite = std::isfinite(value);
        if (!finite && bad != nullptr) (*bad)[i] = 1;
        *plane.at(x, y) = finite ? std::clamp(value, -kBrightest, kBrightest) : 0;
      }
    }
    return plane;
  }
  const std::string& missing() const { return missing_; }

 private:
  const Image& image_;
  std::string missing_;
};

template <class F>
void for_each_pixel(const NoisyPicture& picture, F&& f) {
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) f(x, y);
  }
}

/// Samples of a pixel, the same in all: adaptive pictures have no halves.
absl::StatusOr<std::uint32_t> samples_of(const Image& image) {
  const auto found = image.metadata.find("tessera.spp");
  const auto* const spp = found == image.metadata.end() ? nullptr : std::get_if<std::int32_t>(&found->second);
  if (spp == nullptr || *spp < 1) return absl::InvalidArgumentError("the attribute tessera.spp is missing");
  if (*spp < 2)
    return absl::InvalidArgumentError("one sample a pixel tells nothing of its noise; 2 or more do");
  return static_cast<std::uint32_t>(*spp);
}

/// The other half, from the mean of all samples and the channel half.*, which is scaled as if halves were
/// equal (wire/halves.h).
void split(Plane& first, Plane& second, const Plane& mean, std::uint32_t samples) {
  const float share = static_cast<float>(wire::first_half_of(samples)) / static_cast<float>(samples);
  for (int y = 0; y < mean.height(); ++y) {
    for (int x = 0; x < mean.width(); ++x) {
      const float part = 0.5f * *first.at(x, y);
      *first.at(x, y) = part / share;
      *second.at(x, y) = (*mean.at(x, y) - part) / (1 - share);
    }
  }
}

/// Cuts down lone pixels that are several times as bright as all but one in the square of 5 x 5 around them:
/// single paths, whose light no average of neighbours makes less of a spot. What pixels side by side agree on
/// is left, and so are pixels whose halves agree.
void cut_fireflies(NoisyPicture& picture) {
  constexpr int kRadius = 2;
  constexpr float kTimes = 4;
  struct Cut {
    int x, y;
    float factor;
  };
  const auto light = [&](int x, int y) {
    float sum = 0;
    for (int c = 0; c < 3; ++c) sum += *picture.first[c].at(x, y) + *picture.second[c].at(x, y);
    return sum;
  };
  std::vector<Cut> cuts;
  for_each_pixel(picture, [&](int x, int y) {
    const float own = light(x, y);
    float first = 0, second = 0;  // the brightest others
    for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, picture.height - 1); ++v) {
      for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, picture.width - 1); ++u) {
        if (u == x && v == y) continue;
        const float other = light(u, v);
        second = std::max(second, std::min(first, other));
        first = std::max(first, other);
      }
    }
    if (own <= kTimes * second || own <= 0) return;
    float apart = 0;
    for (int c = 0; c < 3; ++c) apart += std::abs(*picture.first[c].at(x, y) - *picture.second[c].at(x, y));
    if (apart > 0.25f * own) cuts.push_back({x, y, second / own});
  });
  for (const Cut& cut : cuts) {
    for (int c = 0; c < 3; ++c) {
      *picture.first[c].at(cut.x, cut.y) *= cut.factor;
      *picture.second[c].at(cut.x, cut.y) *= cut.factor;
      *picture.variance[c].at(cut.x, cut.y) *= cut.factor * cut.factor;
    }
  }
  picture.fireflies = cuts.size();
}

/// The variance of a half, as its samples tell it, is right where they are independent; those of a sequence
/// cancel in part. The halves' difference knows that, but is itself noise: it scales what samples say, over
/// squares of 17 x 17 pixels [Rousselle et al. 2012].
void scale_variance(NoisyPicture& picture, int threads) {
  constexpr int kRadius = 8;
  for (int c = 0; c < 3; ++c) {
    Plane apart(picture.width, picture.height);
    for_each_pixel(picture, [&](int x, int y) {
      const float difference = *picture.first[c].at(x, y) - *picture.second[c].at(x, y);
      *apart.at(x, y) = 0.5f * difference * difference;
    });
    const Plane seen = box_mean(apart, kRadius, threads);
    const Plane said = box_mean(picture.variance[c], kRadius, threads);
    for_each_pixel(picture, [&](int x, int y) {
      const float factor = *said.at(x, y) > 0 ? *seen.at(x, y) / *said.at(x, y) : 1;
      *picture.variance[c].at(x, y) *= std::clamp(factor, 0.05f, 2.0f);
    });
  }
}

/// Few samples know little of their variance; those of the next pixels know about as much, where they show
/// the same thing.
void find_usual_variance(NoisyPicture& picture, int threads) {
  for (Plane& plane : picture.usual) plane = Plane(picture.width, picture.height);
  const auto weight = [&](int x, int y, int u, int v) {
    float distance = 0;
    for (std::size_t g = 0; g < picture.guides.size(); ++g) {
      const float apart = (*picture.guides[g].at(x, y) - *picture.guides[g].at(u, v)) / kGuideScale[g];
      distance += apart * apart;
    }
    const float near = 1 / (1 + distance);
    return near * near;
  };
  parallel_for(static_cast<std::size_t>(picture.height), threads, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width; ++x) {
      float weights = 0, sums[3] = {};
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, picture.height - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, picture.width - 1); ++u) {
          const float w = weight(x, y, u, v);
          weights += w;
          for (int c = 0; c < 3; ++c) sums[c] += w * *picture.variance[c].at(u, v);
        }
      }
      for (int c = 0; c < 3; ++c) *picture.usual[c].at(x, y) = sums[c] / weights;
    }
  });
}

/// Fills pixels of which nothing is known with the mean of those around them that are known, with a
/// variance that says so.
void fill_unknown(NoisyPicture& picture, const std::vector<char>& bad) {
  constexpr int kRadius = 3;
  const NoisyPicture as_read = picture;
  for_each_pixel(picture, [&](int x, int y) {
    if (bad[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
            static_cast<std::size_t>(x)] == 0)
      return;
    ++picture.not_finite;
    for (int c = 0; c < 3; ++c) {
      float sum = 0;
      int known = 0;
      for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, picture.height - 1); ++v) {
        for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, picture.width - 1); ++u) {
          if (bad[static_cast<std::size_t>(v) * static_cast<std::size_t>(picture.width) +
                  static_cast<std::size_t>(u)] != 0)
            continue;
          sum += 0.5f * (*as_read.first[c].at(u, v) + *as_read.second[c].at(u, v));
          ++known;
        }
      }
      const float mean = known > 0 ? sum / static_cast<float>(known) : 0;
      *picture.first[c].at(x, y) = *picture.second[c].at(x, y) = mean;
      *picture.variance[c].at(x, y) = mean * mean;
    }
  });
}

/// Reads the planes of one feature and filters them.
void add_guides(Reader& reader, const std::vector<std::string>& names, std::uint32_t samples, int threads,
                NoisyPicture& picture) {
  std::vector<Plane> means, variances;
  for (const std::string& name : names) {
    Plane mean = reader.read(name), first = reader.read(absl::StrCat("half.", name));
    if (!reader.missing().empty()) continue;
    Plane second(picture.width, picture.height);
    split(first, second, mean, samples);
    Plane apart(picture.width, picture.height);
    const bool is_depth = name == "depth.Z";
    for_each_pixel(picture, [&](int x, int y) {
      float a = *first.at(x, y), b = *second.at(x, y);
      if (is_depth) {  // how far apart things look: nothing is at 0
        a = std::log(std::max(a, 0.0f) + 1e-3f), b = std::log(std::max(b, 0.0f) + 1e-3f);
        *mean.at(x, y) = std::log(std::max(*mean.at(x, y), 0.0f) + 1e-3f);
      }
      *apart.at(x, y) = 0.25f * (a - b) * (a - b);
    });
    mean.extend();
    means.push_back(std::move(mean));
    variances.push_back(box_mean(apart, 1, threads));
  }
  if (!reader.missing().empty()) return;
  for (Plane& guide : filter_features(means, variances, picture.inside, threads))
    picture.guides.push_back(std::move(guide));
}

}  // namespace

PlaneView view(const Plane& plane) { return {plane.at(0, 0), plane.stride()}; }

absl::StatusOr<NoisyPicture> read_noisy_picture(const Image& image, const std::string& prefix, int threads) {
  const absl::StatusOr<std::uint32_t> samples = samples_of(image);
  if (!samples.ok()) return samples.status();
  NoisyPicture picture;
  picture.width = image.data.width(), picture.height = image.data.height();
  picture.inside = Plane(picture.width, picture.height);
  for_each_pixel(picture, [&](int x, int y) { *picture.inside.at(x, y) = 1; });

  Reader reader(image);
  std::vector<char> bad(image.pixel_count());
  for (std::size_t c = 0; c < 3; ++c) {
    const Plane mean = reader.read(absl::StrCat(prefix, kColours[c]), &bad);
    picture.first[c] = reader.read(absl::StrCat("half.", kColours[c]), &bad);
    picture.second[c] = Plane(picture.width, picture.height);
    split(picture.first[c], picture.second[c], mean, *samples);
    picture.variance[c] = reader.read(absl::StrCat("variance.", kColours[c]), &bad);
    for_each_pixel(picture, [&](int x, int y) {
      float& variance = *picture.variance[c].at(x, y);
      variance = std::max(variance, 0.0f) * 2 / static_cast<float>(*samples);
    });
  }
  const auto albedo = wire::colour_channels_of("albedo");
  for (const std::vector<std::string>& names : {std::vector<std::string>(albedo.begin(), albedo.end()),
                                                {"normal.X", "normal.Y", "normal.Z"},
                                                {"depth.Z"}})
    add_guides(reader, names, *samples, threads, picture);
  if (!reader.missing().empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("channels are missing: ", reader.missing(),
                     "; render with --aov variance,albedo,normal,depth,halves"));
  }
  fill_unknown(picture, bad);
  cut_fireflies(picture);
  scale_variance(picture, threads);
  find_usual_variance(picture, threads);
  for (std::size_t c = 0; c < 3; ++c) {
    picture.first[c].extend(), picture.second[c].extend(), picture.variance[c].extend();
    picture.usual[c].extend();
  }
  return picture;
}

}  // namespace tessera::client::denoise
