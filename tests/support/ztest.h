// The test that an image is right within its noise, against a reference with known variance.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tessera::test {

/// Rows from the top, three doubles a pixel.
struct ZImage {
  std::size_t width = 0, height = 0;
  std::vector<double> rgb;
};

struct ZOptions {
  double spp = 0;  // of the tested image, whose samples are independent
  double reference_spp = 32000;
  double alpha = 0.01;          // of the whole image, for the pixel checks
  double alpha_of_sums = 1e-3;  // of the whole image, for the block and global checks
  double fraction = 0.9975;     // of all pixels and channels that must be accepted
  std::size_t block = 8;        // pixels a side
  double tolerance = 1e-3;      // relative difference of sums that does not count
};

struct ZCheck {
  bool pass = false;
  double accepted = 0;  // fraction of the values
  double max_z = 0;
};

/// suite: the rule of Mitsuba 3's render tests, in XYZ with the reference's variance of one sample.
/// own: the same in RGB with the tested image's own variance, and that of the reference's mean.
/// block, global: of means over blocks and over the image, so that small uniform errors show.
struct ZResult {
  ZCheck suite, own, block, global;
  std::size_t bad_pixels = 0;  // not finite
  double bias_percent[3] = {0, 0, 0};

  bool pass() const { return suite.pass && own.pass && block.pass && global.pass && bad_pixels == 0; }
  std::string report() const;
};

/// `reference_variance` is of one sample, measured in XYZ and stored through the XYZ to RGB matrix;
/// `variance` of one sample in RGB. All images have the same size.
ZResult z_test(const ZImage& reference, const ZImage& reference_variance, const ZImage& tested,
               const ZImage& variance, const ZOptions& options);

}  // namespace tessera::test
