// How an image is shown on a screen of 8 bits.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"
#include "spectra/color/rgb_space.h"

namespace tessera::client {

/// The sRGB code, from 0 to 1, of a linear value (IEC 61966-2-1), which is clamped; 0 of what is no number.
float srgb_encoded(float linear);

/// The look of a file for screens.
struct ViewOptions {
  double exposure_stops = 0;
  // One of the views below, or one of the configuration's display; empty: `srgb`, or the display's own.
  std::string name;
  // The path of an OpenColorIO configuration, the display of it that is shown (empty: its own choice), and
  // the space of it that the image is in.
  std::string ocio_config, ocio_display;
  std::string ocio_space = "scene_linear";
  bool dithers = false;

  bool operator==(const ViewOptions&) const = default;
};

/// Makes colours of a scene those of a screen.
class DisplayView {
 public:
  virtual ~DisplayView() = default;
  /// Replaces linear colours, Rec.709 or what takes_rec709() says, by codes of an sRGB screen from 0 to 1.
  virtual void show(std::span<spectra::Triple> row) const = 0;
  /// False where colours are taken as the image has them.
  virtual bool takes_rec709() const { return true; }
};

/// The views that need no configuration. `srgb`: values are clamped. `filmic`: each of red, green and blue
/// along the fit of [Narkowicz2015] to the ACES curve. `aces`: the fit of [Hill2017] to the reference
/// rendering and output transforms, in which bright colours turn white. `agx`: primaries moved towards white,
/// then a sigmoid of the logarithm of exposure, after [Sobotka2022].
const std::vector<std::string>& builtin_views();

/// InvalidArgument for a view, display, space or configuration that is not there; the message names those
/// that are.
absl::StatusOr<std::unique_ptr<DisplayView>> make_display_view(const ViewOptions& options);

}  // namespace tessera::client
