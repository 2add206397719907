// The pictures and times that a pilot has of each algorithm that it tries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tessera::client {

/// The film of a pilot's pictures, and the pixels of it that are rendered: the job's, made smaller.
struct PilotFrame {
  std::uint32_t film_width = 0, film_height = 0;
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  std::uint32_t width() const { return x1 - x0; }
  std::uint32_t height() const { return y1 - y0; }
  std::size_t pixels() const { return std::size_t{width()} * height(); }
};

/// Samples [sample_begin, sample_end) of each pixel, with a seed of their own: pictures of one candidate are
/// independent.
struct PilotImage {
  std::vector<float> values;  // red of all pixels, then green, then blue; rows from the top
  std::uint32_t sample_begin = 0, sample_end = 0;
  double cpu_seconds = 0;

  std::uint32_t samples() const { return sample_end - sample_begin; }
};

struct PilotCandidate {
  std::string name;
  bool consistent = false;         // its bias falls as samples come (wire::Bias::kConsistent)
  int ways = 1;                    // one with more finds light in all ways of those with fewer, and in others
  std::vector<PilotImage> images;  // an even number, of equal size and sample count
};

/// The job that a pilot is about.
struct PilotJob {
  std::uint32_t width = 0, height = 0;           // the film
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // the part of it that is rendered
  std::uint32_t spp = 1;

  double pixels() const { return double(x1 - x0) * double(y1 - y0); }
};

}  // namespace tessera::client
