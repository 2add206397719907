// The test that images agree with a reference of known variance, within their noise and a tolerance.
#pragma once

#include <cstddef>
#include <vector>

namespace tessera::test {

/// Rows from the top, three doubles a pixel.
struct RgbPlanes {
  std::size_t width = 0, height = 0;
  std::vector<double> rgb;
};

/// `variance` is of one sample, measured in CIE XYZ and stored through the XYZ to RGB matrix, as in Mitsuba's
/// suite: it has a meaning in XYZ alone, where stored values may stand for negative ones.
struct ReferenceImage {
  RgbPlanes mean, variance;
  double spp = 0;
};

/// How likely a difference as large as the one seen is when there is none beyond what is allowed. Each of the
/// three is a p-value.
struct ImageAgreement {
  double pixels = 1;  // Mitsuba's rule: at most 0.25 % of the pixels may be beyond their noise
  double blocks = 1;  // means of 8 x 8 pixels
  double whole = 1;   // mean of the image
  double bias_percent[3] = {0, 0, 0};  // bias of the mean colour

  /// P-value of all three together [Bonferroni].
  double p_value() const;
};

struct AgreementOptions {
  double spp = 0;           // the image's samples per pixel; they are independent
  double tolerance = 1e-3;  // systematic error of the reference that does not count, of its value
};

/// Compares in XYZ, where light of all colours adds to every value. `variance` is that of one of the image's
/// samples, in RGB. A value is off by no more than noise where the mean lies within the tolerance of the
/// reference's, to which the reference's own noise adds as a fixed error: it is the same for all images that
/// are held against it, whose p-values are therefore independent. All have the same size.
ImageAgreement agreement(const ReferenceImage& reference, const RgbPlanes& image, const RgbPlanes& variance,
                         const AgreementOptions& options);

}  // namespace tessera::test
