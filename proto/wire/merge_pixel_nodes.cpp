// The arithmetic of the sum tree. Compiled with -ffp-contract=off (see CMakeLists.txt): every operation below
// is one IEEE operation, so its result does not depend on compiler or machine.
#include "wire/tile_result.h"

namespace tessera::wire {
namespace {

void merge_sums(std::size_t pixels, float* left, const float* right) {
  for (std::size_t i = 0; i < pixels; ++i) left[i] += right[i];
}

/// The left node's, unless it has no sample.
void merge_firsts(std::size_t pixels, const std::uint32_t* left_counts, float* left, const float* right) {
  for (std::size_t i = 0; i < pixels; ++i) {
    if (left_counts[i] == 0) left[i] = right[i];
  }
}

/// M2 = M2_a + M2_b + (mean_b - mean_a)^2 n_a n_b / (n_a + n_b) [Chan et al. 1979, eq. 2.1]; in double,
/// rounded once. Needs the sums and counts as they were before their own merge.
void merge_squared_deviations(std::size_t pixels, const std::uint32_t* left_counts, const float* left_sums,
                              float* left, const std::uint32_t* right_counts, const float* right_sums,
                              const float* right) {
  for (std::size_t i = 0; i < pixels; ++i) {
    double between = 0.0;
    if (left_counts[i] != 0 && right_counts[i] != 0) {
      const double n_left = left_counts[i];
      const double n_right = right_counts[i];
      const double difference = right_sums[i] / n_right - left_sums[i] / n_left;
      between = difference * difference * (n_left * n_right / (n_left + n_right));
    }
    left[i] = static_cast<float>((static_cast<double>(left[i]) + static_cast<double>(right[i])) + between);
  }
}

void merge_lists(std::size_t pixels, float* left, std::size_t left_stride, const float* right,
                 std::size_t right_stride) {
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t entry = 0; entry < kListEntries; ++entry) {
      const float* const pair = right + 2 * entry * right_stride + i;
      add_to_list(left + i, left_stride, pair[0], pair[right_stride]);
    }
  }
}

}  // namespace

void add_to_list(float* list, std::size_t stride, float identifier, float weight) {
  if (weight == 0) return;
  float *free = nullptr, *least = nullptr;
  for (std::size_t entry = 0; entry < kListEntries; ++entry) {
    float* const pair = list + 2 * entry * stride;
    if (pair[stride] == 0) {
      if (free == nullptr) free = pair;
    } else if (pair[0] == identifier) {
      pair[stride] += weight;
      return;
    } else if (least == nullptr || pair[stride] < least[stride]) {
      least = pair;
    }
  }
  float* const place = free != nullptr ? free : least;
  if (free == nullptr && weight <= least[stride]) return;
  place[0] = identifier;
  place[stride] = weight;
}

void merge_pixel_nodes(const std::vector<ChannelDesc>& channels, std::size_t pixels,
                       std::uint32_t* left_counts, float* left, std::size_t left_stride,
                       const std::uint32_t* right_counts, const float* right, std::size_t right_stride) {
  // Deviations first: they look at the sums of both sides.
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind != ChannelKind::kSquaredDeviation) continue;
    const std::size_t of = channels[c].of;
    merge_squared_deviations(pixels, left_counts, left + of * left_stride, left + c * left_stride,
                             right_counts, right + of * right_stride, right + c * right_stride);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == ChannelKind::kSum)
      merge_sums(pixels, left + c * left_stride, right + c * right_stride);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == ChannelKind::kFirst)
      merge_firsts(pixels, left_counts, left + c * left_stride, right + c * right_stride);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == ChannelKind::kEntry && channels[c].of == c)
      merge_lists(pixels, left + c * left_stride, left_stride, right + c * right_stride, right_stride);
  }
  for (std::size_t i = 0; i < pixels; ++i) left_counts[i] += right_counts[i];
}

}  // namespace tessera::wire
