#include "denoise/mixture.h"

#include <algorithm>

namespace tessera::client::denoise {
namespace {

/// The relative squared error of a candidate, estimated over 5 x 5 pixels: of its halves, what each differs
/// by from the other half as it is, less that half's noise; of their mean, a quarter of their squared
/// difference less.
Plane error_of(const NoisyPicture& picture, const Candidate& candidate, const Plane& scale, int threads) {
  constexpr int kRadius = 2;
  Plane error(picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      float sum = 0;
      for (int c = 0; c < 3; ++c) {
        const float a = *candidate.first[c].at(x, y) - *picture.second[c].at(x, y);
        const float b = *candidate.second[c].at(x, y) - *picture.first[c].at(x, y);
        const float apart = *candidate.first[c].at(x, y) - *candidate.second[c].at(x, y);
        sum += 0.5f * (a * a + b * b) - 0.25f * apart * apart - *picture.variance[c].at(x, y);
      }
      *error.at(x, y) = sum * *scale.at(x, y);
    }
  }
  return box_mean(error, kRadius, threads);
}

/// 1 / (squared light + its variance + 0.01), so that errors of bright pixels do not decide for dark ones.
Plane error_scale(const NoisyPicture& picture) {
  Plane scale(picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      float light = 0, variance = 0;
      for (int c = 0; c < 3; ++c) {
        light += (*picture.first[c].at(x, y) + *picture.second[c].at(x, y)) / 6;
        variance += *picture.usual[c].at(x, y) / 6;
      }
      *scale.at(x, y) = 1 / (light * light + variance + 0.01f);
    }
  }
  return scale;
}

/// How much of each candidate every pixel gets: all of the one with the least error, smoothed over 5 x 5
/// pixels.
std::vector<Plane> choose(const NoisyPicture& picture, const std::vector<Candidate>& candidates,
                          int threads) {
  const Plane scale = error_scale(picture);
  std::vector<Plane> errors, shares;
  for (const Candidate& candidate : candidates)
    errors.push_back(error_of(picture, candidate, scale, threads));
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Plane chosen(picture.width, picture.height);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const auto least =
            std::ranges::min_element(errors, {}, [x, y](const Plane& error) { return *error.at(x, y); });
        *chosen.at(x, y) = least - errors.begin() == static_cast<std::ptrdiff_t>(i) ? 1.0f : 0.0f;
      }
    }
    shares.push_back(box_mean(chosen, 2, threads));
  }
  return shares;
}

}  // namespace

Colours mixed(const NoisyPicture& picture, std::vector<Candidate> candidates, int threads) {
  candidates.push_back({picture.first, picture.second});
  const std::vector<Plane> shares = choose(picture, candidates, threads);
  Colours result;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        float sum = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
          sum += *shares[i].at(x, y) *
                 (0.5f * (*candidates[i].first[c].at(x, y) + *candidates[i].second[c].at(x, y)));
        }
        result[c].push_back(sum);
      }
    }
  }
  return result;
}

}  // namespace tessera::client::denoise
