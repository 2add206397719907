#include "pilot/judge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "bench/bias.h"
#include "image/image.h"
#include "image/metrics.h"
#include "pilot/mean.h"
#include "pilot/missing_light.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

constexpr double kLeastError = 1e-12;  // a picture without any is as good as the next one

struct Moments {
  std::vector<double> mean;
  double mse = 0;  // variance of `mean`, mean over values
};

Moments moments_of(const PilotCandidate& candidate) {
  const std::size_t values = candidate.images.front().values.size(), images = candidate.images.size();
  Moments moments{std::vector<double>(values)};
  for (std::size_t i = 0; i < values; ++i) {
    for (const PilotImage& image : candidate.images) moments.mean[i] += double{image.values[i]};
    moments.mean[i] /= static_cast<double>(images);
    for (const PilotImage& image : candidate.images) {
      const double off = double{image.values[i]} - moments.mean[i];
      moments.mse += off * off;
    }
  }
  moments.mse /= static_cast<double>(values) * static_cast<double>(images) * static_cast<double>(images - 1);
  return moments;
}

/// The candidates' shares in what is taken for the right picture: by precision, without those that lack
/// light.
std::vector<double> shares_of(std::span<const Moments> moments, std::span<const char> trusted) {
  std::vector<double> shares(moments.size());
  double largest = 0, sum = 0;
  for (const Moments& one : moments) largest = std::max(largest, one.mse);
  for (std::size_t c = 0; c < shares.size(); ++c) {
    // No candidate is taken for a million times as precise as another: of one picture, none is noise.
    if (trusted[c]) shares[c] = 1 / std::max({moments[c].mse, 1e-6 * largest, 1e-30});
    sum += shares[c];
  }
  for (double& share : shares) share /= sum > 0 ? sum : 1;
  return shares;
}

/// The mean of each value and its neighbours in the plane.
std::vector<double> smoothed(std::span<const double> values, const PilotFrame& frame) {
  const auto width = static_cast<std::ptrdiff_t>(frame.width()),
             height = static_cast<std::ptrdiff_t>(frame.height());
  std::vector<double> means(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto pixel = static_cast<std::ptrdiff_t>(i % frame.pixels()),
               plane = static_cast<std::ptrdiff_t>(i) - pixel;
    const std::ptrdiff_t x = pixel % width, y = pixel / width;
    double sum = 0, count = 0;
    for (std::ptrdiff_t row = std::max<std::ptrdiff_t>(y - 1, 0); row < std::min(y + 2, height); ++row) {
      for (std::ptrdiff_t column = std::max<std::ptrdiff_t>(x - 1, 0); column < std::min(x + 2, width);
           ++column) {
        sum += values[static_cast<std::size_t>(plane + row * width + column)];
        ++count;
      }
    }
    means[i] = sum / count;
  }
  return means;
}

/// The weighted mean of the candidates' means.
std::vector<double> pooled(std::span<const Moments> moments, std::span<const double> shares) {
  std::vector<double> reference(moments.front().mean.size());
  for (std::size_t c = 0; c < moments.size(); ++c) {
    for (std::size_t i = 0; i < reference.size(); ++i) reference[i] += shares[c] * moments[c].mean[i];
  }
  return reference;
}

/// The divisor of values.
std::vector<double> norms_of(std::span<const Moments> moments, std::span<const double> shares,
                             const PilotFrame& frame) {
  std::vector<double> norms = smoothed(pooled(moments, shares), frame);
  for (double& norm : norms) norm = std::sqrt(norm * norm + CompareOptions{}.epsilon);
  return norms;
}

/// The variance of one picture, relative as relMSE.
Mean variance_of(const PilotCandidate& candidate, const Moments& moments, std::span<const double> norms) {
  const double images = static_cast<double>(candidate.images.size());
  std::vector<double> squares(candidate.images.size());
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const std::vector<float>& values = candidate.images[k].values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double off = (values[i] - moments.mean[i]) / norms[i];
      squares[k] += off * off;
    }
    squares[k] *= images / (images - 1) / static_cast<double>(values.size());
  }
  return mean_of(squares);
}

/// The median: the first pictures find cold caches.
double time_of(const PilotCandidate& candidate) {
  std::vector<double> times;
  for (const PilotImage& image : candidate.images) times.push_back(image.cpu_seconds);
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::ranges::nth_element(times, middle);
  return *middle;
}

Image image_of(std::span<const double> values, const PilotFrame& frame) {
  Image image;
  image.data.x1 = static_cast<std::int32_t>(frame.width());
  image.data.y1 = static_cast<std::int32_t>(frame.height());
  image.display = image.data;
  std::size_t next = 0;
  for (const char* const name : wire::kColourChannels) {
    for (float& value : image.add(name).values) value = static_cast<float>(values[next++]);
  }
  return image;
}

/// The square of a consistent candidate's bias: by how much it differs from the unbiased ones, with these
/// variances of a picture. 0 where that is not seen.
double bias_of(const PilotCandidate& candidate, std::span<const PilotCandidate> candidates,
               std::span<const Moments> moments, std::span<const Mean> variances,
               std::span<const char> trusted, const PilotFrame& frame) {
  std::vector<char> unbiased(candidates.size());
  for (std::size_t c = 0; c < candidates.size(); ++c) unbiased[c] = trusted[c] && !candidates[c].consistent;
  const std::vector<double> shares = shares_of(moments, unbiased);
  double noise = 0, sum = 0;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    sum += shares[c];
    noise += shares[c] * shares[c] * variances[c].value / static_cast<double>(candidates[c].images.size());
  }
  if (sum == 0) return 0;
  const Image right = image_of(pooled(moments, shares), frame);
  BiasEstimator estimator(right, noise, static_cast<std::uint32_t>(candidate.images.size()));
  for (const PilotImage& image : candidate.images)
    estimator.add(image_of(std::vector<double>(image.values.begin(), image.values.end()), frame));
  const BiasAndVariance apart = estimator.result();
  return apart.is_biased() ? apart.bias2 : 0;
}

/// A candidate that varies less than one with more ways to find light.
struct Doubt {
  bool is_doubted = false;
  std::string varies_less_than;  // where that cannot be; else empty
};

/// Doubts about each candidate, by the variances of a picture.
std::vector<Doubt> doubts_about(std::span<const PilotCandidate> candidates, std::span<const Mean> variances,
                                const PilotFrame& frame, std::span<const double> norms) {
  constexpr double kClear = 2.33;   // standard errors: one in a hundred
  constexpr double kExcess = 1.64;  // one in twenty
  std::vector<Doubt> doubts(candidates.size());
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Mean& narrow = variances[c];
    double largest = narrow.value;
    for (std::size_t other = 0; other < candidates.size(); ++other) {
      const Mean& broad = variances[other];
      if (candidates[other].ways <= candidates[c].ways || broad.value <= largest) continue;
      const double error = std::hypot(std::sqrt(narrow.variance) / std::max(narrow.value, kLeastError),
                                      std::sqrt(broad.variance) / broad.value);
      const auto clearly_above = [&](double value) {
        return std::log(broad.value / std::max(value, kLeastError)) > kClear * error;
      };
      if (!clearly_above(narrow.value)) continue;
      doubts[c].is_doubted = true;
      // R^2 at most, relative to R^2 + 0.01.
      const double veach = 1.0 / candidates[other].images.front().samples();
      if (clearly_above(narrow.value + veach) ||
          excess_light(candidates[other], candidates[c], frame, norms) > kExcess)
        largest = broad.value, doubts[c].varies_less_than = candidates[other].name;
    }
  }
  return doubts;
}

}  // namespace

double Judgement::efficiency() const { return 1 / (std::max(variance + bias2, kLeastError) * cpu_seconds); }

std::vector<Judgement> judge(std::span<const PilotCandidate> candidates, const PilotFrame& frame,
                             const PilotJob& job) {
  std::vector<Moments> moments;
  for (const PilotCandidate& candidate : candidates) moments.push_back(moments_of(candidate));
  // First all are trusted, then those that lack no light by the measure of the first.
  std::vector<char> trusted(candidates.size(), 1);
  std::vector<double> norms = norms_of(moments, shares_of(moments, trusted), frame);
  std::vector<MissingLight> missing = find_missing_light(candidates, frame, job.spp, norms);
  const auto all_variances = [&] {
    std::vector<Mean> variances;
    for (std::size_t c = 0; c < candidates.size(); ++c)
      variances.push_back(variance_of(candidates[c], moments[c], norms));
    return variances;
  };
  std::vector<Doubt> doubts = doubts_about(candidates, all_variances(), frame, norms);
  for (std::size_t c = 0; c < candidates.size(); ++c)
    trusted[c] = missing[c].seen_by.empty() && doubts[c].varies_less_than.empty();
  if (std::ranges::count(trusted, 1) > 0) {
    norms = norms_of(moments, shares_of(moments, trusted), frame);
    missing = find_missing_light(candidates, frame, job.spp, norms);
  }

  const std::vector<Mean> variances = all_variances();
  doubts = doubts_about(candidates, variances, frame, norms);
  std::vector<Judgement> judgements(candidates.size());
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const PilotCandidate& candidate = candidates[c];
    Judgement& own = judgements[c];
    const double of_an_image = static_cast<double>(candidate.images.front().samples()) / job.spp;
    own.cpu_seconds = time_of(candidate) / of_an_image * job.pixels() / static_cast<double>(frame.pixels());
    own.variance = variances[c].value * of_an_image;
    own.bias2 = missing[c].error;
    own.lacks_light = missing[c].seen_by;
    own.varies_less_than = doubts[c].varies_less_than;
    own.is_doubted = doubts[c].is_doubted;
    if (candidate.consistent) own.bias2 += bias_of(candidate, candidates, moments, variances, trusted, frame);
    const double error = own.variance + own.bias2;
    own.uncertainty = error > kLeastError ? std::sqrt(variances[c].variance) * of_an_image / error : 0;
  }
  return judgements;
}

}  // namespace tessera::client
