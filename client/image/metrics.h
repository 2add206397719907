// Error of an image against a reference.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

struct CompareOptions {
  double epsilon = 0.01;      // added to R^2 in relMSE
  double trim_percent = 0.1;  // share of the pixels, the worst ones, that the trimmed errors leave out
  int block = 8;              // side in pixels of the blocks whose means have an error of their own
  int test_block = 16;        // the same of the blocks of the significance tests
};

/// Mean difference of one colour channel, over all whole blocks, with a two-sided t-test over the block
/// means: pixels that share a filter's support are correlated, means of blocks hardly.
struct ChannelBias {
  double mean_reference = 0;
  double mean_test = 0;
  double bias = 0;          // test - reference
  double bias_percent = 0;  // percent of mean_reference
  double t = 0;
  double p = 1;
};

struct Comparison {
  std::int32_t width = 0, height = 0;
  std::uint64_t non_finite_pixels = 0;  // found in either image; left out of the errors and 0 in the biases
  // Means over pixels and channels of (T - R)^2 and of (T - R)^2 / (R^2 + epsilon) [Rousselle et al. 2011].
  double mse = 0, mse_trimmed = 0;
  double relmse = 0, relmse_trimmed = 0;
  // relMSE of the means over all blocks of the image, at any place, times the pixels of a block, without the
  // worst pixels. Equal to the pixels' where their errors are independent, larger where errors of neighbours
  // agree: what an eye at a distance, a filter or a denoiser sees.
  int block = 0;
  double relmse_block = 0;
  std::uint64_t blocks = 0;
  std::array<ChannelBias, 3> channels;  // R, G, B
  // Blocks whose own t-test over their pixels rejects equality at 1 % of the whole image, after Sidak's
  // correction for the number of tests: shows local errors that cancel over the image.
  std::uint64_t blocks_rejected = 0;
  std::uint64_t block_tests = 0;  // blocks * 3
};

/// Returns Comparison::relmse_block of images of `width` pixels a row: `difference` is that of red, green and
/// blue from the `reference`. Neither side is less than a block's.
double relmse_of_blocks(const std::array<std::vector<double>, 3>& reference,
                        const std::array<std::vector<double>, 3>& difference, int width, int block,
                        double epsilon);

/// InvalidArgument when sizes differ, are less than a block, or no pixel is finite.
absl::StatusOr<Comparison> compare_images(const Image& reference, const Image& test,
                                          const CompareOptions& options = {});

/// For people; several lines, the last without its end.
std::string to_text(const Comparison& comparison, const CompareOptions& options = {});

/// The fields of Comparison as an object: "size", "non_finite_pixels", "mse", "mse_trimmed", "relmse",
/// "relmse_trimmed", "block", "relmse_block", "blocks", "channels" {"R" {"mean_ref", "mean_test", "bias",
/// "bias_percent", "t", "p"}
/// ...}, "blocks_rejected", "block_tests". Numbers that are not finite are null.
std::string to_json(const Comparison& comparison);

/// Two-sided p-value of Student's t with `dof` degrees of freedom; 0 for an infinite t.
double student_t_p_value(double t, double dof);

/// The t beyond which, either side, Student's distribution has this probability: 0.05 gives the factor of 95
/// % intervals.
double student_t_quantile(double p, double dof);

}  // namespace tessera::client
