// Small pictures with known errors: what two renderings of one scene must agree in, whatever algorithm made
// them.
#pragma once

#include <string>
#include <vector>

#include "support/picture/scene_file.h"

namespace tessera::test {

struct PictureRequest {
  std::string scene;   // a v1::Scene in text form, but for its film
  std::string filter;  // a v1::PixelFilter in text form; empty: a box
  std::string integrator = "path";
  std::string settings;  // further v1::RenderSettings in text form
  std::string isa;       // empty: the best that there is
  std::uint32_t max_depth = 4;
  std::uint32_t spp = 1024;
  std::uint32_t seed = 0;  // every request has others of its own, too
  TestBlobs blobs = {};
};

/// The short form of a test with many pictures takes a quarter of their samples, with twice their noise.
std::uint32_t samples_of_form(std::uint32_t in_long_form);
double noise_of_form(double in_long_form);

/// Light of radiance 1 from everywhere, for PictureRequest::scene.
inline constexpr const char* kSky = " lights { infinite { radiance { constant: 1 } } } ";

/// Means over the whole picture and over its 16 blocks of 8 x 8 pixels, R G B each, with their standard
/// errors. The errors come from batches of samples that share no paths, so they hold for light tracing too,
/// where pixels of one pass are not independent.
struct Picture {
  struct Value {
    double mean = 0, error = 0;
  };
  std::vector<Value> values;  // the whole picture first
  /// Means over the whole picture of all channels of results, bands among them, by wire::channels_of().
  std::vector<Value> channels;

  const Value& whole(int channel) const { return values[static_cast<std::size_t>(channel)]; }
};

/// Empty, with a failure of the running test, when the scene does not load or a sample is not finite.
Picture measure_picture(const PictureRequest& request);

/// Pictures of one scene that differ in their seeds, for tests whose p-values are combined.
using Pictures = std::vector<Picture>;

/// Some of them, which share the request's samples.
Pictures measure_pictures(const PictureRequest& request);

/// A number that is to be zero, as each seed's picture has it.
struct Difference {
  std::string name;
  std::vector<Picture::Value> by_seed;
  double allowed = 0;  // systematic difference that does not count
};

/// Each value of pictures against those of others, seed by seed.
std::vector<Difference> differences_of(const Pictures& a, const Pictures& b, double relative = 1e-3);
/// The same of Picture::channels, from `first` on.
std::vector<Difference> channel_differences(const Pictures& a, const Pictures& b, std::size_t first,
                                            double relative = 1e-3);
/// A number of each picture against one that is known.
Difference difference_from(const std::string& name, const std::vector<Picture::Value>& by_seed,
                           double expected, double relative);

/// The least p-value of the hypotheses that each is no larger than allowed: those of the seeds combined
/// [Fisher 1925], adjusted for the number of hypotheses [Holm 1979], which need not be independent.
double p_value_of(const std::vector<Difference>& differences);
/// Fails where that is below 1e-4, with the differences that are to blame.
void expect_none(const std::vector<Difference>& differences);

/// The same of differences_of(), and of all values against one that is known.
void expect_same(const Pictures& a, const Pictures& b, double relative = 1e-3);
void expect_value(const Pictures& pictures, double expected, double relative = 1e-3);

/// Fails unless all values agree within their noise. Of 51 values, each with at least 31 degrees of freedom,
/// one is off by six standard errors once in 25,000 pictures; `relative` is a difference that does not count.
void expect_same(const Picture& a, const Picture& b, double relative = 1e-3);

/// Fails unless every value is `expected` within its noise, as above.
void expect_value(const Picture& picture, double expected, double relative = 1e-3);

}  // namespace tessera::test
